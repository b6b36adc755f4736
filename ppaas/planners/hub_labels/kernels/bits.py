"""Kernel: lines of bits, 64 to a word, and the distance to the next set bit of a line.

A line is a range of an int64 array. Consecutive words of a line are ``stride`` words apart, so that lines which are
read together can be interleaved. Bit ``p`` of a line is bit p mod 64 of its word p div 64.
"""

from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import joined
from ppaas.planners.kernels.bits import leading_zeros, trailing_zeros

Words = NDArray[np.int64]


def _count(_typing: Any, _word: Any) -> Any:
    def emit(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.ctpop(arguments[0])

    return types.int64(types.uint64), emit


count = cast("Callable[[Any], int]", intrinsic(_count))
"""Number of set bits of a uint64."""


@joined
def is_set(words: Words, line: int, stride: int, bit: int) -> bool:
    """Return whether a bit of a line is set."""
    return bool((words[np.uint64(line + (bit >> 6) * stride)] >> (bit & 63)) & 1)


@joined
def up(words: Words, line: int, stride: int, bit: int, most: int) -> int:
    """Return the number of clear bits from ``bit`` on upwards, limited to ``most``."""
    word = line + (bit >> 6) * stride
    rest = np.uint64(words[np.uint64(word)]) >> np.uint64(bit & 63)
    if rest != 0:
        return min(trailing_zeros(rest), most)
    passed = 64 - (bit & 63)
    while passed < most:
        word += stride
        rest = np.uint64(words[np.uint64(word)])
        if rest != 0:
            return min(passed + trailing_zeros(rest), most)
        passed += 64
    return most


@joined
def down(words: Words, line: int, stride: int, bit: int, most: int) -> int:
    """Return the number of clear bits from ``bit`` on downwards, limited to ``most``."""
    word = line + (bit >> 6) * stride
    rest = np.uint64(words[np.uint64(word)]) << np.uint64(63 - (bit & 63))
    if rest != 0:
        return min(leading_zeros(rest), most)
    passed = (bit & 63) + 1
    while passed < most:
        word -= stride
        rest = np.uint64(words[np.uint64(word)])
        if rest != 0:
            return min(passed + leading_zeros(rest), most)
        passed += 64
    return most
