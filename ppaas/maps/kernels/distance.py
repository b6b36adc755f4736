"""Exact Euclidean distance transform in linear time.

Meijster, Roerdink and Hesselink, "A General Algorithm for Computing Distance Transforms in Linear Time" (2000): first
the distance within each column, then the lower envelope of parabolas along each row.
"""

import math
from collections.abc import Callable

import numpy as np
from numba import njit, prange, types
from numpy.typing import NDArray

from ppaas.maps.kernels.serial import serial_copy

_SIGNATURE = types.float32[:, ::1](types.Array(types.uint8, 2, "C", readonly=True), types.float64)

_BLOCK = 64
"""Columns that one thread takes at a time: a row of them fills whole cache lines."""


@njit(cache=True, nogil=True, error_model="numpy")
def _columns(occupied: NDArray[np.uint8], start: int, stop: int, to_occupied: NDArray[np.int32]) -> None:
    """Write the distance to the nearest occupied cell of the same column, for the columns [start, stop)."""
    height, width = occupied.shape
    none = height + width
    for c in range(start, stop):
        to_occupied[0, c] = 0 if occupied[0, c] else none
    for r in range(1, height):
        for c in range(start, stop):
            to_occupied[r, c] = 0 if occupied[r, c] else min(to_occupied[r - 1, c] + 1, none)
    for r in range(height - 2, -1, -1):
        for c in range(start, stop):
            to_occupied[r, c] = min(to_occupied[r, c], to_occupied[r + 1, c] + 1)


@njit(cache=True, nogil=True, error_model="numpy")
def _row(column: NDArray[np.int32], resolution: float, distance: NDArray[np.float32]) -> None:
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


def _transform(occupied: NDArray[np.uint8], resolution: float) -> NDArray[np.float32]:
    height, width = occupied.shape
    to_occupied = np.empty((height, width), np.int32)
    for block in prange((width + _BLOCK - 1) // _BLOCK):
        _columns(occupied, block * _BLOCK, min((block + 1) * _BLOCK, width), to_occupied)
    distance = np.empty((height, width), np.float32)
    for r in prange(height):
        _row(to_occupied[r], resolution, distance[r])
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
