"""Localization: where a robot stands in its map, told from its odometry and its laser."""
