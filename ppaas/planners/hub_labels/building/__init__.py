"""TODO ppaas/planners/hub_labels/building."""
