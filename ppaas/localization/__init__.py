"""Localization: adaptive Monte Carlo localization of a robot in its map, from odometry and laser scans."""
