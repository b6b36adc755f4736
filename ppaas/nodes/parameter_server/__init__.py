"""TODO ppaas/nodes/parameter_server."""
