"""Kernel: distances around a few new obstacles, where those to the obstacles of the map are known.

`ppaas.maps.kernels.distance` computes all distances of a grid. A local costmap needs them only as far as it inflates
obstacles, and of its obstacles only those that are not in the map are new: far fewer cells are looked at.
"""

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

SLACK = 0.001
"""Distance by which distances are exact beyond those at which obstacles have costs [m]."""

FEW = 64
"""Number of cells to look at around new obstacles, per cell of the grid, up to which this is the faster way."""

_SIGNATURE = types.void(types.uint8[:, ::1], types.float64, types.int64, types.float32[:, ::1])


def reach_in_cells(distance: float, resolution: float) -> int:
    """Return the number of cells up to which distances must be exact, if those up to ``distance`` [m] must be."""
    return math.ceil((distance + SLACK) / resolution)


def are_few(new: NDArray[np.bool_], reach: int) -> bool:
    """Return whether `lower_near` is faster for cells with new obstacles than to compute all distances."""
    return int(np.count_nonzero(new)) * (2 * reach + 1) ** 2 <= FEW * new.size


@compiled(_SIGNATURE)
def lower_near(new: NDArray[np.uint8], resolution: float, reach: int, distance: NDArray[np.float32]) -> None:
    """Lower distances to those from new obstacles, as far as these reach; farther away they may stay too large.

    Parameters
    ----------
    new : (height, width) uint8 array
        Not 0 in cells with a new obstacle.
    resolution : float
        Edge of a cell [m].
    reach : int
        Number of cells up to which distances are exact.
    distance : (height, width) float32 array
        Distances to other obstacles [m]; lowered in place.
    """
    height, width = new.shape
    far = 2 * (reach + 1) * (reach + 1)
    squares = np.full((height, width), far, np.int32)
    for r in range(height):
        for c in range(width):
            if not new[r, c]:
                continue
            left, right = max(c - reach, 0), min(c + reach + 1, width)
            for row in range(max(r - reach, 0), min(r + reach + 1, height)):
                up = (row - r) * (row - r)
                for column in range(left, right):
                    squares[row, column] = min(squares[row, column], up + (column - c) * (column - c))
    for r in range(height):
        for c in range(width):
            if squares[r, c] < far:
                distance[r, c] = min(distance[r, c], np.float32(resolution * math.sqrt(squares[r, c])))


def warm() -> None:
    """Call each kernel once."""
    lower_near(np.eye(2, dtype=np.uint8), 0.05, 1, np.ones((2, 2), np.float32))
