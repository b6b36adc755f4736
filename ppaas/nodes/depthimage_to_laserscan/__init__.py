"""Node ``depthimage_to_laserscan``: laser scans from the images of a depth camera."""
