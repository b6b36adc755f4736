"""The BARN navigation benchmark: a Jackal among cylinders, driven without a map by its odometry and its laser."""
