"""Decorators for kernels that call other kernels often: compiled without reference counting.

numba increments and decrements the reference counts of all arrays at each call, in atomic steps that take longer than
reading a word. Kernels that allocate no arrays do not need that: the Python caller holds all of them.
"""

from typing import Any

from numba import njit

_njit: Any = njit  # its annotations lack the private option _nrt

bare = _njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
"""Decorator of a kernel."""

inlined = _njit(nogil=True, error_model="numpy", _nrt=False, inline="always")
"""Decorator of a part of kernels that numba inlines into its callers: a call would pass each array as seven numbers."""

joined = _njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
"""Decorator of a small kernel that LLVM inlines into its callers. Callers of many such kernels compile several times
faster than with ``inlined``, and run as fast."""
