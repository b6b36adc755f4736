"""Kernels of searches from cell to cell, compiled by numba."""

from ppaas.kernel_cache import watch_all_kernels

watch_all_kernels()
