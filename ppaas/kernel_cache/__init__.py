"""numba's cache of this project's kernels: when it is valid, for which processors, and what was compiled elsewhere."""
