"""Maps: occupancy grids, their files, and the layers that are derived from them once and shared by all."""
