"""Growth of arrays in slices, with checks for cancellation in between."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T", bound=np.generic)

SLICE_COPIED = 1 << 22
"""Bytes copied between two checks: 2 ms if the memory is newly allocated."""


def doubled(array: NDArray[T], check: Callable[[], None]) -> NDArray[T]:
    """Return an array twice as long that begins with the same items; the rest is uninitialized.

    Parameters
    ----------
    array : (n, …) array
    check : callable
        Called at least every few milliseconds. If it raises, ``array`` is unchanged.
    """
    count = len(array)
    larger = np.empty((2 * count, *array.shape[1:]), array.dtype)
    step = max(1, SLICE_COPIED * count // max(1, array.nbytes))
    for first in range(0, count, step):
        check()
        last = min(first + step, count)
        larger[first:last] = array[first:last]
    return larger
