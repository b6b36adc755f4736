"""TODO ppaas/controllers/pure_pursuit."""
