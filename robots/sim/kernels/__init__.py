"""Inner loops of the simulated world, compiled by numba."""
