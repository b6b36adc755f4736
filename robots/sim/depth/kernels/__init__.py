"""Kernels of the simulated depth camera, compiled by numba."""
