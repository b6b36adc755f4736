"""Kernels that are in the cache are loaded without numba's compiler.

Before numba looks into its cache it loads all that it would compile with, which takes a quarter of a second and 10 MB
of the memory that all containers share. Only its runtime is needed for code that is compiled. What is not in the
cache is compiled as ever: whatever compiles loads the compiler itself.
"""

import functools
from collections.abc import Callable
from typing import Any

from numba.core.base import BaseContext
from numba.core.caching import Cache
from numba.core.runtime.nrt import rtsys


def load_without_compiler() -> None:
    """Let numba load what it compiles with only when it compiles; call it once, before any kernel is called."""
    loading: Callable[..., Any] = Cache.load_overload

    @functools.wraps(loading)
    def load_overload(cache: Cache, signature: Any, context: BaseContext) -> Any:
        vars(context)["refresh"] = functools.partial(rtsys.initialize, context)
        try:
            return loading(cache, signature, context)
        finally:
            del vars(context)["refresh"]

    Cache.load_overload = load_overload  # type: ignore[method-assign]
