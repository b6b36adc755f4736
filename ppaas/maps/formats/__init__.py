"""TODO ppaas/maps/formats."""
