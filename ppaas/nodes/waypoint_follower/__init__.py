"""TODO ppaas/nodes/waypoint_follower."""
