"""TODO ppaas/controllers/dwa."""
