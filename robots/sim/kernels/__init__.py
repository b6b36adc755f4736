"""Kernels of the simulated world, compiled by numba."""
