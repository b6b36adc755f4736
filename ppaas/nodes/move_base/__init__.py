"""Node ``move_base``: drives the robot to its goals, with a global and a local planner."""
