"""Kernels of 3D mapping: rays through voxels, updates of blocks, leaves of octrees, points of depth images."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
