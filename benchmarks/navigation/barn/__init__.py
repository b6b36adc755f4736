"""The BARN navigation benchmark: a Jackal drives among cylinders without a map, by odometry and laser."""
