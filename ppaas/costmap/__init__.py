"""Costmaps: the cost of each cell for the robot, with the values of costmap_2d."""
