"""Mapping: 2D graph SLAM from laser scans and odometry."""
