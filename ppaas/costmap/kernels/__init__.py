"""Compiled kernels over costmaps. Each module has a ``warm`` that calls all of its kernels once."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
