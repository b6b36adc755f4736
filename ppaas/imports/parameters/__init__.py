"""Parameter files of ROS programs, translated into robot files."""
