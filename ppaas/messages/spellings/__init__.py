"""Text of messages as clients spell it: times of ROS 1 and ROS 2, and JSON beyond the standard."""
