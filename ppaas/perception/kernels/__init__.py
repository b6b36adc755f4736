"""Kernels of perception."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
