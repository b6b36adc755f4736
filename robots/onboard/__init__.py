"""The local node manager: nodes of a robot's clone, run on the robot."""
