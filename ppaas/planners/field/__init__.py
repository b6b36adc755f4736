"""TODO ppaas/planners/field."""
