"""TODO ppaas/nodes/amcl."""
