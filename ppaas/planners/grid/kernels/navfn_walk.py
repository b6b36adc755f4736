"""Kernel: walk down the gradient of a navigation function, as navfn's path does.

A step of half a cell goes along the normalised gradient, interpolated between the four cells around. Where one of the
nine cells around the nearest is not reached, or the gradient leads nowhere, the walk goes to the lowest neighbour of
that cell instead. So it always ends: whenever it comes to another cell, that one's potential is lower, and a reached
cell has a lower neighbour unless it is the goal. And it never leaves the cells that were reached, nor cuts a corner.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Int = int | np.signedinteger[Any]
Floats = NDArray[np.float32]

STEP = 0.5
"""Cells."""

LONGEST_STAY = 4
"""Steps within one cell before the walk goes on to its lowest neighbour: three cross a cell from corner to corner."""


@njit(cache=True, nogil=True, error_model="numpy")
def _slope(potentials: Floats, cell: Int, apart: Int) -> float:
    """Return how fast the potential falls from one neighbour of a reached cell to that on the other side."""
    here, slope = np.float64(potentials[cell]), 0.0
    if potentials[cell - apart] < np.inf:
        slope += potentials[cell - apart] - here
    if potentials[cell + apart] < np.inf:
        slope += here - potentials[cell + apart]
    return slope


@njit(cache=True, nogil=True, error_model="numpy")
def _gradient(potentials: Floats, stride: int, row: float, column: float) -> tuple[float, float]:
    """Return the direction downhill at a place between four reached cells: row, column, of about unit length."""
    first_row, first_column = np.int64(np.floor(row)), np.int64(np.floor(column))
    up, right = row - first_row, column - first_column
    along_rows, along_columns = 0.0, 0.0
    for below in range(2):
        for beside in range(2):
            cell = (first_row + below) * stride + first_column + beside
            share = (up if below else 1.0 - up) * (right if beside else 1.0 - right)
            down, across = _slope(potentials, cell, stride), _slope(potentials, cell, 1)
            length = np.hypot(down, across)
            if share > 0.0 and length > 0.0:
                along_rows += share * down / length
                along_columns += share * across / length
    return along_rows, along_columns


@njit(cache=True, nogil=True, error_model="numpy")
def _surrounded(potentials: Floats, stride: int, cell: Int) -> bool:
    """Tell whether a cell and the eight around it are reached."""
    for first in (cell - stride - 1, cell - 1, cell + stride - 1):
        for beside in range(3):
            if not potentials[first + beside] < np.inf:
                return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _lowest(potentials: Floats, stride: int, cell: Int) -> Int:
    """Return the lowest neighbour of a reached cell; a diagonal one needs both cells beside the move."""
    lowest = cell
    for down in (-stride, 0, stride):
        for right in (-1, 0, 1):
            passable = potentials[cell + down] < np.inf and potentials[cell + right] < np.inf
            if passable and potentials[cell + down + right] < potentials[lowest]:
                lowest = cell + down + right
    return lowest


@njit(cache=True, nogil=True, error_model="numpy")
def _add(potentials: Floats, stride: int, cells: NDArray[np.int32], count: Int, row: Int, column: Int) -> Int:
    """Add a cell to a path of neighbours, in place of the last one if that is a corner that need not be gone round."""
    if count > 1:
        last_row, last_column = np.int64(cells[count - 2, 0]) + 1, np.int64(cells[count - 2, 1]) + 1
        if abs(row - last_row) == 1 and abs(column - last_column) == 1:
            sides = max(potentials[row * stride + last_column], potentials[last_row * stride + column])
            count -= 1 if sides < np.inf else 0
    cells[count, 0], cells[count, 1] = row - 1, column - 1
    return count + 1


@njit(cache=True, nogil=True, error_model="numpy")
def walk(
    potentials: Floats, stride: int, goal: int, place: NDArray[np.float64], stay: Int,
    cells: NDArray[np.int32], points: NDArray[np.float64],
) -> tuple[Int, Int, Int]:  # fmt: skip
    """Walk on until the goal is reached or the arrays are full.

    Parameters
    ----------
    potentials : (n,) float32 array
        Padded, infinite where not reached; the place where the walk begins is reached.
    stride : int
        Elements in a row.
    goal : int
        The cell of potential 0.
    place : (2,) float64 array
        Row and column, padded, where the walk is; whole numbers are centres. In and out.
    stay : int
        Steps taken so far within the cell it is in.
    cells : (m, 2) int32 array
        Out: row, column on the map of the cells walked through, from the one where it is to the goal; each is a
        neighbour of the one before, and where two moves make a diagonal one, they are one.
    points : (m, 2) float64 array
        Out: where each step began, in rows and columns of the map.

    Returns
    -------
    tuple of int
        How many cells and points there are, and the stay. The last cell is the goal if it was reached; else another
        call goes on, and may begin in that cell again.
    """
    count: Int = 0
    before: Int = -1
    points_count = 0
    while points_count < points.shape[0]:
        row, column = np.int64(np.floor(place[0] + 0.5)), np.int64(np.floor(place[1] + 0.5))
        here = row * stride + column
        if here != before:
            count = _add(potentials, stride, cells, count, row, column)
            before = here
        if here == goal:
            place[0], place[1] = row, column
        points[points_count, 0], points[points_count, 1] = place[0] - 1.0, place[1] - 1.0
        points_count += 1
        if here == goal:
            break
        gradual = False
        if stay < LONGEST_STAY and _surrounded(potentials, stride, here):
            down, across = _gradient(potentials, stride, place[0], place[1])
            length = np.hypot(down, across)
            if length > 0.0:
                ahead, aside = place[0] + STEP * down / length, place[1] + STEP * across / length
                following = np.int64(np.floor(ahead + 0.5)) * stride + np.int64(np.floor(aside + 0.5))
                gradual = following == here or potentials[following] < potentials[here]
        if not gradual:
            following = np.int64(_lowest(potentials, stride, here))
            ahead, aside = np.float64(following // stride), np.float64(following % stride)
        stay = stay + 1 if following == here else 0
        place[0], place[1] = ahead, aside
    return count, points_count, stay


def warm() -> None:
    """Compile and call the kernel once."""
    potentials = np.full(25, np.inf, np.float32)
    potentials[12], potentials[13] = 50.0, 0.0
    walk(potentials, 5, 13, np.array([2.0, 2.0]), 0, np.empty((2, 2), np.int32), np.empty((2, 2)))
