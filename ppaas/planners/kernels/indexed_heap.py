"""Kernels: indexed binary heap of cells. The entry of each cell is stored, so that its key can be changed in place.

A key has two parts, compared lexicographically; integers below 2⁵³ are exact in them. The root is entry 1: the entry 0
means that a cell is not in the heap, and zeroed arrays are an empty heap.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Int = int | np.signedinteger[Any]
Float = float | np.floating[Any]
Keys = NDArray[np.float64]
Cells = NDArray[np.int32]
Places = NDArray[np.int32]


@compiled
def _settle(
    keys: Keys, cells: Cells, places: Places, size: Int, hole: Int, cell: Int, major: Float, minor: Float
) -> None:
    """Insert a cell at a free entry and sift it up or down to restore the heap order."""
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


@compiled
def put(keys: Keys, cells: Cells, places: Places, size: Int, cell: Int, major: Float, minor: Float) -> Int:
    """Insert a cell, or change the key of a cell that is in the heap; return the new size.

    Parameters
    ----------
    keys : (capacity, 2) float64 array
        Both parts of each key; entry 0 is not used.
    cells : (capacity,) int32 array
        The cell of each entry.
    places : (n,) int32 array
        The entry of each cell; 0 if it is not in the heap.
    size : int
        Number of cells in the heap, less than ``capacity − 1``.
    cell : int
        The cell.
    major, minor : float
        Its key.
    """
    if places[cell] == 0:
        size += 1
        places[cell] = size
    _settle(keys, cells, places, size, np.int64(places[cell]), cell, major, minor)
    return size


@compiled
def drop(keys: Keys, cells: Cells, places: Places, size: Int, cell: Int) -> Int:
    """Remove a cell, if it is in the heap; return the new size."""
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
