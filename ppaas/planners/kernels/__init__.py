"""Kernels and numba intrinsics that several families of planners share."""

from ppaas.kernel_cache import watch_all_kernels

watch_all_kernels()
