"""Costmaps: what a cell costs the robot, in the values of costmap_2d."""
