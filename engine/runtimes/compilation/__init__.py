"""Compilation: compiles the numba kernels into the cache, and chooses the threading layer."""
