"""Inner loops of fleet plans."""

from ppaas.kernel_cache.locators import watch_all_kernels

watch_all_kernels()
