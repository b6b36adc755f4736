"""Kernels of localization. They receive random numbers as arrays, so that the seed determines the result."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
