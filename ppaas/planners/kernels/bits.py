"""Kernel: find bits that are set. Position p of an array of words is bit p mod 64 of its word p // 64.

Places are unsigned: an index that cannot count from the end needs no look whether it does.
"""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from ppaas.planners.kernels.jit_decorators import bare

Words = NDArray[np.uint64]

# Its annotations tell what it is given as what it makes.
_intrinsic = cast("Callable[[Callable[[Any, Any], Any]], Callable[[Any], int]]", intrinsic)


@_intrinsic
def trailing_zeros(_typing: Any, _word: Any) -> Any:
    """Return at which bit the lowest one of a word is; 64 without any."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 0))

    return types.int64(types.uint64), generate


@_intrinsic
def leading_zeros(_typing: Any, _word: Any) -> Any:
    """Return how many zeros are before the highest one of a word; 64 without any."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.ctlz(arguments[0], ir.Constant(ir.IntType(1), 0))

    return types.int64(types.uint64), generate


@bare
def is_set(words: Words, at: int) -> bool:
    """Tell whether a bit is set."""
    return bool((words[np.uint64(at >> 6)] >> np.uint64(at & 63)) & np.uint64(1))


@bare
def first_from(words: Words, at: int) -> int:
    """Return the first position from ``at`` on that is set; there must be one."""
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
    """Return the last position up to ``at`` that is set; there must be one."""
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
    """Return the bits before, at and behind a position, the first one lowest."""
    place, shift = np.uint64((at - 1) >> 6), np.uint64((at - 1) & 63)
    word = words[place] >> shift
    if shift > np.uint64(61):
        word |= words[place + np.uint64(1)] << (np.uint64(64) - shift)
    return int(np.int64(word & np.uint64(7)))
