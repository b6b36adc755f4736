"""Kernel: the bits of a float64 as an int64, and back."""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

# numba annotates `intrinsic` as if it returned its argument.
_to_int = cast("Callable[[Callable[[Any, Any], Any]], Callable[[float | np.float64], int]]", intrinsic)
_to_float = cast("Callable[[Callable[[Any, Any], Any]], Callable[[int | np.int64], float]]", intrinsic)


@_to_int
def bits_of(_typing: Any, _value: Any) -> Any:
    """Return the bits of a float64."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), generate


@_to_float
def float_of(_typing: Any, _bits: Any) -> Any:
    """Return the float64 of bits."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), generate
