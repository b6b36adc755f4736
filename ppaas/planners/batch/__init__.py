"""TODO ppaas/planners/batch."""
