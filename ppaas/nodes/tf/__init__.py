"""TODO ppaas/nodes/tf."""
