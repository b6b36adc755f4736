"""Node monitor: decides which nodes of a clone run in the cloud, which on the robot, and explains why."""
