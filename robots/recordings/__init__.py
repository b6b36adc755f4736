"""Recordings of robots: logs of CARMEN, graphs of poses with scans, and bags of ROS."""
