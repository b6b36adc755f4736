"""TODO ppaas/nodes/planner_server."""
