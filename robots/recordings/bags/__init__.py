"""Bags of ROS as tools leave them: MCAP, SQLite and bags of ROS 1, folders of them, compressed, cut off."""
