"""TODO ppaas/nodes/move_base."""
