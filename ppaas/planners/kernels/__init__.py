"""Kernels and numba intrinsics that several families of planners share."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
