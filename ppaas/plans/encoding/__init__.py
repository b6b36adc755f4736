"""TODO ppaas/plans/encoding."""
