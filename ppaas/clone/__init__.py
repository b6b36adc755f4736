"""TODO ppaas/clone."""
