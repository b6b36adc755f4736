"""TODO ppaas/planners/grid."""
