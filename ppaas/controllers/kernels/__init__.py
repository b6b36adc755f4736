"""Kernels of the local planners; import from the modules."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
