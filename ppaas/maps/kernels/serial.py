"""Helper for kernels that are compiled twice, for several threads and for one."""

from collections.abc import Callable
from types import FunctionType
from typing import Any


def serial_copy(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a copy of a function under another name, to be compiled without ``parallel``.

    numba's cache on disk identifies a function by its name and argument types, but not by its compilation options.
    Under the same name, the variant that is stored first would be loaded for both.
    """
    assert isinstance(function, FunctionType)
    name = f"{function.__name__}_serial"
    copy = FunctionType(function.__code__, function.__globals__, name, function.__defaults__, function.__closure__)
    copy.__qualname__ = name
    copy.__module__ = function.__module__
    return copy
