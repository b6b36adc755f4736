"""Maps: occupancy grids, voxel grids and octrees, their files, and quantities derived from them."""
