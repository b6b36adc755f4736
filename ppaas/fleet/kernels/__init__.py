"""Inner loops of fleet plans."""

from ppaas.kernel_cache import watch_all_kernels

watch_all_kernels()
