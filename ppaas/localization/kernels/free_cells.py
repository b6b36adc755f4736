"""Kernels: selection of free cells of a map by number, without a list of them, which would be larger than the map."""

import numpy as np
from numba import types
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.grid import FREE

_CELLS = types.Array(types.int8, 2, "C", readonly=True)
_NUMBERS = types.Array(types.int64, 1, "C", readonly=True)


@compiled(types.int64[::1](_CELLS))
def count_free(data: NDArray[np.int8]) -> NDArray[np.int64]:
    """Return for each row the number of free cells in it and all rows below it, (height,) from (height, width)."""
    height, width = data.shape
    below = np.empty(height, np.int64)
    total = 0
    for row in range(height):
        for column in range(width):
            total += data[row, column] == FREE
        below[row] = total
    return below


@compiled(types.int64[:, ::1](_CELLS, _NUMBERS, _NUMBERS))
def find_free(data: NDArray[np.int8], below: NDArray[np.int64], numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return row and column of free cells by their numbers, which count the free cells row by row.

    Parameters
    ----------
    data : (height, width) int8 array
        Occupancy.
    below : (height,) array
        Result of `count_free`.
    numbers : (n,) array
        Numbers of free cells from 0, in ascending order, so that each row is read at most once.

    Returns
    -------
    (n, 2) array
        row, column.
    """
    found = np.empty((numbers.size, 2), np.int64)
    row = column = 0
    passed = np.int64(0)  # free cells before (row, column)
    for i in range(numbers.size):
        # Skip the rows that end before this number, then count free cells within the row.
        if below[row] <= numbers[i]:
            while below[row] <= numbers[i]:
                row += 1
            column, passed = 0, below[row - 1]
        while True:
            if data[row, column] == FREE:
                if passed == numbers[i]:
                    break
                passed += 1
            column += 1
        found[i, 0], found[i, 1] = row, column
    return found


def warm() -> None:
    """Call each kernel once, so that it is compiled or loaded from the cache."""
    cells = np.zeros((1, 1), np.int8)
    find_free(cells, count_free(cells), np.zeros(1, np.int64))
