"""Node ``docking_server``: docks the robot, and undocks it."""
