"""Kernels: a binary heap of cells that knows where each cell is, so that keys change in place.

A key has two parts, compared one after the other; whole numbers below 2⁵³ are exact in them. The root is entry 1:
so a place of 0 says that a cell is not in the heap, and arrays of zeros are an empty one.

numba's cache of a kernel looks at the kernel's own file alone: after a change here, remove the ``*.nbi`` files.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Int = int | np.signedinteger[Any]
Float = float | np.floating[Any]
Keys = NDArray[np.float64]
Cells = NDArray[np.int32]
Places = NDArray[np.int32]


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(
    keys: Keys, cells: Cells, places: Places, size: Int, hole: Int, cell: Int, major: Float, minor: Float
) -> None:
    """Put a cell where its key belongs, up or down from an entry that is free."""
    at = hole
    while at > 1:
        above = at >> 1
        if keys[above, 0] < major or (keys[above, 0] == major and keys[above, 1] <= minor):
            break
        keys[at, 0], keys[at, 1], cells[at] = keys[above, 0], keys[above, 1], cells[above]
        places[cells[at]] = at
        at = above
    while 2 * at <= size:
        below = 2 * at
        if below < size and (
            keys[below + 1, 0] < keys[below, 0]
            or (keys[below + 1, 0] == keys[below, 0] and keys[below + 1, 1] < keys[below, 1])
        ):
            below += 1
        if major < keys[below, 0] or (major == keys[below, 0] and minor <= keys[below, 1]):
            break
        keys[at, 0], keys[at, 1], cells[at] = keys[below, 0], keys[below, 1], cells[below]
        places[cells[at]] = at
        at = below
    keys[at, 0], keys[at, 1], cells[at] = major, minor, cell
    places[cell] = at


@njit(cache=True, nogil=True, error_model="numpy")
def put(keys: Keys, cells: Cells, places: Places, size: Int, cell: Int, major: Float, minor: Float) -> Int:
    """Put a cell in, or give the one that is in another key; return how many there are now.

    Parameters
    ----------
    keys : (capacity, 2) float64 array
        Both parts of each key; entry 0 is not used.
    cells : (capacity,) int32 array
        The cell of each entry.
    places : (n,) int32 array
        The entry of each cell; 0 for none.
    size : int
        Cells in the heap: fewer than ``capacity − 1``.
    cell : int
    major, minor : float
        Its key.
    """
    if places[cell] == 0:
        size += 1
        places[cell] = size
    _settle(keys, cells, places, size, np.int64(places[cell]), cell, major, minor)
    return size


@njit(cache=True, nogil=True, error_model="numpy")
def drop(keys: Keys, cells: Cells, places: Places, size: Int, cell: Int) -> Int:
    """Take a cell out, if it is in; return how many there are now."""
    hole = np.int64(places[cell])
    if hole == 0:
        return size
    places[cell] = 0
    last = np.int64(cells[size])
    if last != cell:
        _settle(keys, cells, places, size - 1, hole, last, keys[size, 0], keys[size, 1])
    return size - 1


def warm() -> None:
    """Compile and call each kernel once."""
    keys, cells, places = np.zeros((4, 2)), np.zeros(4, np.int32), np.zeros(2, np.int32)
    size = put(keys, cells, places, 0, 1, 2.0, 1.0)
    drop(keys, cells, places, size, 1)
