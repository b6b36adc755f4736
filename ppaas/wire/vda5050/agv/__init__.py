"""State machine of an AGV: orders, instant actions and the robot's progress in, commands and states out."""
