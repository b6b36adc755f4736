"""TODO ppaas/plans/reuse."""
