"""TODO ppaas/nodes/depthimage_to_laserscan."""
