"""Kernel: find set bits. Position p of an array of 64-bit words is bit p mod 64 of word p // 64.

Indices are unsigned: numba then omits the check for negative indices.
"""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare

Words = NDArray[np.uint64]

# numba annotates `intrinsic` as if it returned its argument.
_intrinsic = cast("Callable[[Callable[[Any, Any], Any]], Callable[[Any], int]]", intrinsic)


@_intrinsic
def trailing_zeros(_typing: Any, _word: Any) -> Any:
    """Return the number of the lowest set bit of a word; 64 if it is 0."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 0))

    return types.int64(types.uint64), generate


@_intrinsic
def leading_zeros(_typing: Any, _word: Any) -> Any:
    """Return the number of zeros above the highest set bit of a word; 64 if it is 0."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.ctlz(arguments[0], ir.Constant(ir.IntType(1), 0))

    return types.int64(types.uint64), generate


@bare
def is_set(words: Words, at: int) -> bool:
    """Return whether a bit is set."""
    return bool((words[np.uint64(at >> 6)] >> np.uint64(at & 63)) & np.uint64(1))


@bare
def first_from(words: Words, at: int) -> int:
    """Return the first set position from ``at`` on; there must be one."""
    place = np.uint64(at >> 6)
    word = words[place] >> np.uint64(at & 63)
    if word != 0:
        return int(at + trailing_zeros(word))
    while True:
        place += np.uint64(1)
        word = words[place]
        if word != 0:
            return int(np.int64(place << np.uint64(6)) + trailing_zeros(word))


@bare
def last_until(words: Words, at: int) -> int:
    """Return the last set position up to ``at``; there must be one."""
    place = np.uint64(at >> 6)
    word = words[place] << np.uint64(63 - (at & 63))
    if word != 0:
        return int(at - leading_zeros(word))
    while True:
        place -= np.uint64(1)
        word = words[place]
        if word != 0:
            return int(np.int64(place << np.uint64(6)) + 63 - leading_zeros(word))


@bare
def three_at(words: Words, at: int) -> int:
    """Return the bits before, at and after a position; the first one is the lowest bit of the result."""
    place, shift = np.uint64((at - 1) >> 6), np.uint64((at - 1) & 63)
    word = words[place] >> shift
    if shift > np.uint64(61):
        word |= words[place + np.uint64(1)] << (np.uint64(64) - shift)
    return int(np.int64(word & np.uint64(7)))
