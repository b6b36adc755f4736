"""Parts of a bridge that do not depend on how it reaches the robot."""
