"""Kernels of localization, compiled by numba. They take random numbers as arrays, so that a seed decides all."""

from ppaas.kernel_cache import watch_all_kernels

watch_all_kernels()
