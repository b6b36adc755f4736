"""Kernels that divide, encode and decode many plans at once, compiled by numba."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
