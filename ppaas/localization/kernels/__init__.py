"""Kernels of localization, compiled by numba. They take random numbers as arrays, so that a seed decides all."""
