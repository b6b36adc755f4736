"""Node ``parameter_server``: the robot's parameters as a tree, by the names of rosparam."""
