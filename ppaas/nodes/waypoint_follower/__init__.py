"""Node ``waypoint_follower``: drives the robot along a list of goals."""
