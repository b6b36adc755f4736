"""Kernels: plans cut, told as bytes and read again, many at a time."""

from ppaas.kernel_cache import watch_all_kernels

watch_all_kernels()
