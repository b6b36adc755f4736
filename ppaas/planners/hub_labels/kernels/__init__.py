"""Inner loops of building, asking and mending the index, compiled by numba."""

from ppaas.kernel_cache import watch_all_kernels

watch_all_kernels()
