"""Kernel: descend the gradient of a navigation function, as navfn's path does.

Each step is half a cell along the normalized gradient, interpolated between the four nearest cells. If one of the nine
cells around the nearest one is not reached, or the gradient vanishes, the walk goes to the lowest neighbour of that
cell instead. The walk always ends: each further cell has a lower potential, and every reached cell except the goal has
a lower neighbour. It never leaves the reached cells, and cuts no corners.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Int = int | np.signedinteger[Any]
Floats = NDArray[np.float32]

STEP = 0.5
"""Length of a step [cells]."""

LONGEST_STAY = 4
"""Maximum number of steps within one cell, before the walk goes to its lowest neighbour: three steps cross a cell
diagonally."""


@compiled
def _slope(potentials: Floats, cell: Int, apart: Int) -> float:
    """Return the decrease of the potential across a reached cell, from ``cell − apart`` to ``cell + apart``."""
    here, slope = np.float64(potentials[cell]), 0.0
    if potentials[cell - apart] < np.inf:
        slope += potentials[cell - apart] - here
    if potentials[cell + apart] < np.inf:
        slope += here - potentials[cell + apart]
    return slope


@compiled
def _gradient(potentials: Floats, stride: int, row: float, column: float) -> tuple[float, float]:
    """Return the downhill direction at a place between four reached cells: row, column, of about unit length."""
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


@compiled
def _surrounded(potentials: Floats, stride: int, cell: Int) -> bool:
    """Return whether a cell and its eight neighbours are reached."""
    for first in (cell - stride - 1, cell - 1, cell + stride - 1):
        for beside in range(3):
            if not potentials[first + beside] < np.inf:
                return False
    return True


@compiled
def _lowest(potentials: Floats, stride: int, cell: Int) -> Int:
    """Return the lowest neighbour of a reached cell; a diagonal move needs both cells beside it reached."""
    lowest = cell
    for down in (-stride, 0, stride):
        for right in (-1, 0, 1):
            passable = potentials[cell + down] < np.inf and potentials[cell + right] < np.inf
            if passable and potentials[cell + down + right] < potentials[lowest]:
                lowest = cell + down + right
    return lowest


@compiled
def _add(potentials: Floats, stride: int, cells: NDArray[np.int32], count: Int, row: Int, column: Int) -> Int:
    """Append a cell to a path; it replaces the last cell if a diagonal move can bypass that one."""
    if count > 1:
        last_row, last_column = np.int64(cells[count - 2, 0]) + 1, np.int64(cells[count - 2, 1]) + 1
        if abs(row - last_row) == 1 and abs(column - last_column) == 1:
            sides = max(potentials[row * stride + last_column], potentials[last_row * stride + column])
            count -= 1 if sides < np.inf else 0
    cells[count, 0], cells[count, 1] = row - 1, column - 1
    return count + 1


@compiled
def walk(
    potentials: Floats, stride: int, goal: int, place: NDArray[np.float64], stay: Int,
    cells: NDArray[np.int32], points: NDArray[np.float64],
) -> tuple[Int, Int, Int]:  # fmt: skip
    """Continue the walk until the goal is reached or the arrays are full.

    Parameters
    ----------
    potentials : (n,) float32 array
        Padded potentials, infinite if not reached; the cell where the walk begins must be reached.
    stride : int
        Number of elements in a row.
    goal : int
        The cell of potential 0.
    place : (2,) float64 array
        Current row and column on the padded map; whole numbers are centres. In and out.
    stay : int
        Number of steps taken so far within the current cell.
    cells : (m, 2) int32 array
        Out: row, column on the map of the crossed cells, from the current one on; each is a neighbour of the one
        before, and two cardinal moves that can be replaced by a diagonal one are.
    points : (m, 2) float64 array
        Out: row, column on the map of the begin of each step.

    Returns
    -------
    cells, points : int
        Numbers of cells and points written. The last cell is the goal if it was reached; otherwise the next call
        continues, and may begin in that cell again.
    stay : int
        Number of steps taken within the last cell.
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
