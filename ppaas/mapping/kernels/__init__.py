"""Kernels of mapping: points and normals of scans, scan alignment, correlative search."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
