"""Kernels: exact Euclidean distance transform, in a pass over columns and a pass over rows.

The first pass computes g(r, c), the distance from cell (r, c) to the nearest occupied cell of the same column. The
squared distance of a cell then is the minimum of g(r, c')² + (c − c')² over all cells c' of its row. The second pass
finds this minimum in one of two ways:

* If all cells of a row are near obstacles, only few neighbours c' matter. They are tried in the order of |c − c'|, for
  the whole row at once (which vectorises), until farther ones cannot lower any cell.
* Else by the lower envelope of parabolas (Meijster, Roerdink and Hesselink, "A General Algorithm for Computing Distance
  Transforms in Linear Time", 2000, second phase), whose time does not depend on the map.
"""

import math
from collections.abc import Callable

import numpy as np
from numba import prange, types
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.serial import serial_copy

_SIGNATURE = types.float32[:, ::1](types.Array(types.uint8, 2, "C", readonly=True), types.float64)

Shorts = NDArray[np.uint16]

_NONE = np.uint16(65535)
"""Distance within a column that has no occupied cell."""

_BLOCK = 128
"""Number of columns per parallel task; a row of them fills whole cache lines, and the block fits the cache."""

_ROWS = 32
"""Number of rows per parallel task."""

_REACH = 128
"""Largest |c − c'| that the search among neighbours tries."""

_AT_ONCE = 8
"""Number of steps of |c − c'| between two checks whether the search can end."""

_FAR = 200
"""Cap of column distances in the search among neighbours, so that _FAR² + _REACH² is below 2¹⁶. Capped distances are
never part of a result, since they exceed _REACH."""


@compiled
def _columns(occupied: NDArray[np.uint8], start: int, stop: int, to_occupied: Shorts) -> None:
    """First pass: write g, the distance to the nearest occupied cell of the same column [cells].

    Parameters
    ----------
    occupied : (height, width) uint8 array
        Not 0 in occupied cells.
    start, stop : int
        Range of columns to process, ``stop`` excluded.
    to_occupied : (height, width) uint16 array
        Out: g, `_NONE` in columns without an occupied cell.
    """
    height, width, one = len(occupied), stop - start, np.uint16(1)
    # Upwards: distance to the nearest occupied cell with a smaller or equal row.
    for r in range(height):
        here, walls = to_occupied[r, start:stop], occupied[r, start:stop]
        above = to_occupied[max(r - 1, 0), start:stop]
        for c in range(width):
            further = np.uint16(min(above[c], _NONE - one) + one) if r else _NONE
            here[c] = np.uint16(0) if walls[c] else further
    # Downwards: the minimum with the distance to the nearest one with a larger row.
    for r in range(height - 2, -1, -1):
        here, below = to_occupied[r, start:stop], to_occupied[r + 1, start:stop]
        for c in range(width):
            here[c] = min(here[c], np.uint16(min(below[c], _NONE - one) + one))


@compiled
def _try_near(column: Shorts, squares: Shorts, least: Shorts) -> bool:
    """Second pass by search among neighbours: write the squared distances of one row.

    Parameters
    ----------
    column : (width,) uint16 array
        g of the row [cells].
    squares : (width + 2 · _REACH,) uint16 array
        Scratch: g² of the row, capped at `_FAR`², with `_REACH` cells of `_FAR`² on both sides.
    least : (width,) uint16 array
        Out: squared distances [cells²].

    Returns
    -------
    bool
        False if an obstacle may be farther than `_REACH` from some cell; ``least`` then is not valid.
    """
    width = len(column)
    own = squares[_REACH : _REACH + width]
    for c in range(width):
        capped = np.uint32(min(column[c], np.uint16(_FAR)))
        own[c] = least[c] = np.uint16(capped * capped)
    for first in range(1, _REACH, _AT_ONCE):
        for across in range(first, first + _AT_ONCE):
            square = np.uint16(across * across)
            left, right = squares[_REACH - across :], squares[_REACH + across :]
            for c in range(width):
                least[c] = min(least[c], np.uint16(min(left[c], right[c]) + square))
        # Neighbours that were not tried yet contribute at least (first + _AT_ONCE)².
        farthest = np.uint16(0)
        for c in range(width):
            farthest = max(farthest, least[c])
        if farthest <= (first + _AT_ONCE) * (first + _AT_ONCE):
            return True
    return False


@compiled
def _envelope(column: NDArray[np.int64], resolution: float, distance: NDArray[np.float32]) -> None:
    """Second pass by the lower envelope of the parabolas g(v)² + (c − v)²: write the distances of one row.

    Parameters
    ----------
    column : (width,) int64 array
        g of the row [cells].
    resolution : float
        Edge of a cell [m].
    distance : (width,) float32 array
        Out: distances [m].
    """
    width = column.size
    # The envelope as a stack: parabola ``vertex[i]`` is the lowest from column ``begin[i]`` to ``begin[i + 1]``.
    vertex = np.empty(width, np.int32)
    begin = np.empty(width, np.int32)
    # Scan from left to right: remove parabolas that the one of c undercuts from their begin on, and push that of c.
    vertex[0] = begin[0] = 0
    last = 0
    for c in range(1, width):
        square = float(column[c]) * column[c]
        while last >= 0:
            v, b = vertex[last], begin[last]
            over = float(column[v]) * column[v] + float(b - v) * (b - v)
            if over <= square + float(b - c) * (b - c):
                break
            last -= 1
        if last < 0:
            last = 0
            vertex[0] = c
            begin[0] = 0
            continue
        v = vertex[last]
        # First column in which the parabola of c is below that of v (Sep in the paper). All numbers are integers below
        # 2⁵³, so the floor is exact.
        rise = float(c) * c - float(v) * v + square - float(column[v]) * column[v]
        meeting = math.floor(rise / (2.0 * (c - v))) + 1.0
        if meeting < width:
            last += 1
            vertex[last] = c
            begin[last] = int(meeting)
    # Scan from right to left: evaluate the envelope.
    for c in range(width - 1, -1, -1):
        v = vertex[last]
        distance[c] = resolution * math.sqrt(float(column[v]) * column[v] + float(c - v) * (c - v))
        if c == begin[last]:
            last -= 1


@compiled
def _rows(to_occupied: Shorts, height: int, resolution: float, distance: NDArray[np.float32]) -> None:
    """Second pass: write the distances of a block of rows.

    Parameters
    ----------
    to_occupied : (n, width) uint16 array
        g of these rows [cells].
    height : int
        Height of the whole map [cells].
    resolution : float
        Edge of a cell [m].
    distance : (n, width) float32 array
        Out: distances [m]; (height + width) · resolution if the map has no occupied cell.
    """
    width, edge = to_occupied.shape[1], np.float32(resolution)
    squares = np.full(width + 2 * _REACH, _FAR * _FAR, np.uint16)
    least = np.empty(width, np.uint16)
    for r in range(len(to_occupied)):
        column, out = to_occupied[r], distance[r]
        if column.min() < _REACH and _try_near(column, squares, least):
            for c in range(width):
                out[c] = edge * np.float32(math.sqrt(np.float32(least[c])))
        else:
            _envelope(np.where(column == _NONE, height + width, column), resolution, out)


def _transform(occupied: NDArray[np.uint8], resolution: float) -> NDArray[np.float32]:
    height, width = occupied.shape
    to_occupied = np.empty((height, width), np.uint16)
    for block in prange((width + _BLOCK - 1) // _BLOCK):
        _columns(occupied, block * _BLOCK, min((block + 1) * _BLOCK, width), to_occupied)
    distance = np.empty((height, width), np.float32)
    for block in prange((height + _ROWS - 1) // _ROWS):
        some = slice(block * _ROWS, min((block + 1) * _ROWS, height))
        _rows(to_occupied[some], height, resolution, distance[some])
    return distance


Transform = Callable[[NDArray[np.uint8], float], NDArray[np.float32]]
"""(h, w) uint8 occupied cells and the edge of a cell [m] → distances [m]; (h + w) · edge if no cell is occupied."""

distance_parallel: Transform = compiled(_SIGNATURE, parallel=True)(_transform)
distance_serial: Transform = compiled(_SIGNATURE)(serial_copy(_transform))
"""The same on one thread, which is faster for small grids such as a local costmap."""


def warm() -> None:
    """Call each kernel once."""
    occupied = np.eye(2, dtype=np.uint8)
    distance_parallel(occupied, 0.05)
    distance_serial(occupied, 0.05)
