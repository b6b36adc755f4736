"""How kernels are compiled that call others all the time: without counting references.

Each call counts the references to its arrays up and down, in atomic steps, which takes longer than a look at a word.
Kernels that make no arrays need no counting: whoever calls from Python holds them all.
"""

from typing import Any

from numba import njit

_njit: Any = njit  # whose annotations leave out the option that numba itself keeps to such kernels

bare = _njit(cache=True, nogil=True, error_model="numpy", _nrt=False)
"""Decorator of a kernel."""

inlined = _njit(nogil=True, error_model="numpy", _nrt=False, inline="always")
"""Decorator of a part of kernels, written into each of them: a call hands over each array as seven numbers."""

joined = _njit(cache=True, nogil=True, error_model="numpy", _nrt=False, forceinline=True)
"""Decorator of a small kernel that LLVM writes into its callers: one that calls many is compiled several times as fast
as with ``inlined``, and runs no slower."""
