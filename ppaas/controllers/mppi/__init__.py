"""TODO ppaas/controllers/mppi."""
