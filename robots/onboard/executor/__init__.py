"""Local executor: the child process in which nodes of a clone run on the robot."""
