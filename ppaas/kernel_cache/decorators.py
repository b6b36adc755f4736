"""Decorators of kernels: the options with which numba compiles them.

Kernels are cached on disk, run without the lock of the interpreter, and divide by zero as numpy does. They have no
wrapper for callers in C, of which there are none: numba compiles 15 % faster without.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar, overload

from numba import njit

Function = TypeVar("Function", bound=Callable[..., Any])

_compiled: Any = partial(njit, nogil=True, error_model="numpy", no_cfunc_wrapper=True)
_cached: Any = partial(_compiled, cache=True)


@overload
def compiled(function: Function, /) -> Function: ...


@overload
def compiled(*signature: Any, **options: Any) -> Callable[[Function], Function]: ...


def compiled(*signature: Any, **options: Any) -> Any:
    """Compile a function as a kernel.

    Parameters
    ----------
    *signature
        Argument types if they are known beforehand, or a list of signatures, as numba takes them; or the function
        itself, where the decorator has no parentheses.
    **options
        Further options of ``numba.njit``.
    """
    return _cached(*signature, **options)


# numba increments and decrements the reference counts of all arrays at each call, in atomic steps that take longer than
# reading a word. Kernels that allocate no arrays do not need that: the Python caller holds all of them.

bare = _cached(_nrt=False)
"""Decorator of a kernel that other kernels call often: compiled without reference counting."""

joined = _cached(_nrt=False, forceinline=True)
"""Decorator of a small kernel, without reference counting, that LLVM inlines into its callers. Callers of many such
kernels compile several times faster than with ``inlined``, and run as fast."""

inlined = _compiled(_nrt=False, inline="always")
"""Decorator of a part of kernels, without reference counting, that numba inlines into its callers: a call would pass
each array as seven numbers."""
