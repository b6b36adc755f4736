"""Kernels of the pose graph: ordering, factorisation with blocks of 3 × 3, and linearised edges."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
