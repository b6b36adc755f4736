"""Compiled kernels over grids. Each module has a function ``warm`` that calls all its kernels once."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
