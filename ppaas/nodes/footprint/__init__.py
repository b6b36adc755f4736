"""Node ``footprint``: the outline of the robot with what it carries."""
