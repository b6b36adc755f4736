"""Transport of robots whose computer has ROS 2: a node of rclpy."""
