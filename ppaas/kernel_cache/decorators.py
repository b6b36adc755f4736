"""Decorators of kernels: the options with which numba compiles them.

Kernels are cached on disk, run without the lock of the interpreter, and divide by zero as numpy does. numba makes no
wrapper for callers in C, and no version for each constant that a caller passes. Nothing uses either, and they take a
tenth of the compile time.
"""

from collections.abc import Callable
from types import FunctionType
from typing import Any, TypeVar, overload

from numba import njit
from numba.core.types import unliteral

Function = TypeVar("Function", bound=Callable[..., Any])

_njit: Any = njit  # its annotations lack the private option _nrt


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
        Options of ``numba.njit``, beside or in place of those of all kernels.
    """
    options = {"cache": True, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True} | options
    if signature and isinstance(signature[0], FunctionType):
        return _for_all_constants(_njit(**options)(signature[0]))
    decorate = _njit(*signature, **options)
    return lambda function: _for_all_constants(decorate(function))


# numba increments and decrements the reference counts of all arrays at each call, in atomic steps that take longer than
# reading a word. Kernels that allocate no arrays do not need that: the Python caller holds all of them.

bare: Any = compiled(_nrt=False)
"""Decorator of a kernel that other kernels call often: compiled without reference counting."""

joined: Any = compiled(_nrt=False, forceinline=True)
"""Decorator of a small kernel, without reference counting, that LLVM inlines into its callers. Callers of many such
kernels compile several times faster than with ``inlined``, and run as fast."""

inlined: Any = compiled(cache=False, _nrt=False, inline="always")
"""Decorator of a part of kernels, without reference counting, that numba inlines into its callers: a call would pass
each array as seven numbers."""
