"""Node ``map_server``: publishes the robot's map and its costmap filters."""
