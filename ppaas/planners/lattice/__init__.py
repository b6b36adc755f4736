"""TODO ppaas/planners/lattice."""
