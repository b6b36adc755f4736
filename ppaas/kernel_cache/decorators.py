"""Decorators of kernels: the options with which numba compiles them.

Kernels are cached on disk, run without the lock of the interpreter, and divide by zero as numpy does. numba compiles
them a tenth faster without two things of which they have no use: a wrapper for callers in C, and a version of its own
for each constant that a caller passes.
"""

from collections.abc import Callable
from functools import partial
from types import FunctionType
from typing import Any, TypeVar, overload

from numba import njit
from numba.core.types import unliteral

Function = TypeVar("Function", bound=Callable[..., Any])

_njit: Any = partial(njit, nogil=True, error_model="numpy", no_cfunc_wrapper=True)


def _with_options(**options: Any) -> Callable[..., Any]:
    """Return a decorator with these options of ``numba.njit``, to be used with or without parentheses."""

    def decorator(*signature: Any, **more: Any) -> Any:
        if signature and isinstance(signature[0], FunctionType):
            return _for_all_constants(_njit(**options | more)(signature[0]))
        decorate = _njit(*signature, **options | more)
        return lambda function: _for_all_constants(decorate(function))

    return decorator


def _for_all_constants(kernel: Any) -> Any:
    """Make the callers of a kernel share one compiled version, whichever constants they pass."""
    if isinstance(kernel, FunctionType):  # NUMBA_DISABLE_JIT
        return kernel
    resolve = kernel.get_call_template
    plain: Callable[[Any], Any] = unliteral

    def get_call_template(args: tuple[Any, ...], kws: dict[str, Any]) -> Any:
        return resolve(tuple(map(plain, args)), {name: plain(of) for name, of in kws.items()})

    kernel.get_call_template = get_call_template
    return kernel


_cached = _with_options(cache=True)


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

bare = _with_options(cache=True, _nrt=False)
"""Decorator of a kernel that other kernels call often: compiled without reference counting."""

joined = _with_options(cache=True, _nrt=False, forceinline=True)
"""Decorator of a small kernel, without reference counting, that LLVM inlines into its callers. Callers of many such
kernels compile several times faster than with ``inlined``, and run as fast."""

inlined = _with_options(_nrt=False, inline="always")
"""Decorator of a part of kernels, without reference counting, that numba inlines into its callers: a call would pass
each array as seven numbers."""
