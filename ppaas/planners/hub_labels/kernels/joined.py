"""How small kernels are compiled that others call all the time: once each, and written into their callers by LLVM.

`ppaas.planners.kernels.bare.inlined` has numba write them in, before it types and lowers the caller: so the caller of
many takes several times as long to compile, and runs no faster.
"""

from typing import Any

from numba import njit

_njit: Any = njit  # whose annotations leave out the options that numba keeps to itself

joined = _njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
"""Decorator of a kernel that makes no array."""
