"""Point clouds: PCD, PLY, LAS and LAZ, E57, and text."""
