"""Inner loops of building, asking and mending the index, compiled by numba."""
