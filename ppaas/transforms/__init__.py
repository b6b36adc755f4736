"""TODO ppaas/transforms."""
