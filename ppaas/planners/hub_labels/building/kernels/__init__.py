"""Kernels that build the index of hub labels, compiled by numba."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
