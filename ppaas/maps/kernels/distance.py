"""Exact Euclidean distance transform: the distance within each column, then along each row.

A cell's distance is the least of √(column² + across²) over all cells of its row. Where nothing in a row is far from an
obstacle, few cells on either side can matter: they are tried nearest first, whole rows at a time, until none farther
off can make a difference. Other rows take the lower envelope of parabolas (Meijster, Roerdink and Hesselink, "A General
Algorithm for Computing Distance Transforms in Linear Time", 2000), which takes the same time whatever is in the map.
"""

import math
from collections.abc import Callable

import numpy as np
from numba import njit, prange, types
from numpy.typing import NDArray

from ppaas.maps.kernels.serial import serial_copy

_SIGNATURE = types.float32[:, ::1](types.Array(types.uint8, 2, "C", readonly=True), types.float64)

Shorts = NDArray[np.uint16]

_NONE = np.uint16(65535)
"""How far an occupied cell is in a column without one."""

_BLOCK = 128
"""Columns that one thread takes at a time: a row of them fills whole cache lines, and all of them the cache."""

_ROWS = 32
"""Rows that one thread takes at a time."""

_REACH = 128
"""Cells to either side that are tried at most."""

_AT_ONCE = 8
"""Of them, between two looks at whether it is enough."""

_FAR = 200
"""Column distances from here on are the same to who tries no more: its square and that of the reach are below 2¹⁶."""


@njit(cache=True, nogil=True, error_model="numpy")
def _columns(occupied: NDArray[np.uint8], start: int, stop: int, to_occupied: Shorts) -> None:
    """Write the distance to the nearest occupied cell of the same column, for the columns [start, stop)."""
    height, width, one = len(occupied), stop - start, np.uint16(1)
    for r in range(height):
        here, walls = to_occupied[r, start:stop], occupied[r, start:stop]
        above = to_occupied[max(r - 1, 0), start:stop]
        for c in range(width):
            further = np.uint16(min(above[c], _NONE - one) + one) if r else _NONE
            here[c] = np.uint16(0) if walls[c] else further
    for r in range(height - 2, -1, -1):
        here, below = to_occupied[r, start:stop], to_occupied[r + 1, start:stop]
        for c in range(width):
            here[c] = min(here[c], np.uint16(min(below[c], _NONE - one) + one))


@njit(cache=True, nogil=True, error_model="numpy")
def _try_near(column: Shorts, squares: Shorts, least: Shorts) -> bool:
    """Write the squared distances of one row; return false where something is too far off for that.

    ``squares`` has ``_REACH`` numbers more than the row before it and behind it, all of ``_FAR``².
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
        farthest = np.uint16(0)
        for c in range(width):
            farthest = max(farthest, least[c])
        if farthest <= (first + _AT_ONCE) * (first + _AT_ONCE):
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _envelope(column: NDArray[np.int64], resolution: float, distance: NDArray[np.float32]) -> None:
    """Write the distance [m] of one row from its distances within each column [cells]."""
    width = column.size
    vertex = np.empty(width, np.int32)  # column whose parabola is lowest …
    begin = np.empty(width, np.int32)  # … from this column on
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
        # Where the parabola of c comes below that of v. All are whole numbers below 2⁵³, so the floor is exact.
        rise = float(c) * c - float(v) * v + square - float(column[v]) * column[v]
        meeting = math.floor(rise / (2.0 * (c - v))) + 1.0
        if meeting < width:
            last += 1
            vertex[last] = c
            begin[last] = int(meeting)
    for c in range(width - 1, -1, -1):
        v = vertex[last]
        distance[c] = resolution * math.sqrt(float(column[v]) * column[v] + float(c - v) * (c - v))
        if c == begin[last]:
            last -= 1


@njit(cache=True, nogil=True, error_model="numpy")
def _rows(to_occupied: Shorts, height: int, resolution: float, distance: NDArray[np.float32]) -> None:
    """Write the distances [m] of some rows from those within each column [cells] of a map of such a height."""
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
"""(h, w) uint8 occupied cells and the edge of a cell [m] → distances [m]; (h + w) · edge where no cell is occupied."""

distance_parallel: Transform = njit(_SIGNATURE, cache=True, nogil=True, error_model="numpy", parallel=True)(_transform)
distance_serial: Transform = njit(_SIGNATURE, cache=True, nogil=True, error_model="numpy")(serial_copy(_transform))
"""The same on one thread: quicker for a window around a robot, which waking other threads would outlast."""


def warm() -> None:
    """Call each kernel once."""
    occupied = np.eye(2, dtype=np.uint8)
    distance_parallel(occupied, 0.05)
    distance_serial(occupied, 0.05)
