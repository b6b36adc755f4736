"""TODO ppaas/nodes/map_server."""
