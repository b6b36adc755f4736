"""Kernels of the planners in space, compiled by numba."""

from ppaas.kernel_cache import watch_all_kernels

watch_all_kernels()
