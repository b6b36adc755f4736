"""Cells that a path crosses, however far apart its points are, and whether all of them are free now."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import GridInfo

Cells = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Crossed:
    """Cells that a path crosses.

    Parameters
    ----------
    cells : (n, 2) int64 array
        Row, column from start to goal; consecutive cells are neighbours.
    corners : (m, 2) int64 array
        Row, column of the two cells beside each diagonal move, which must be free as well.
    """

    cells: Cells
    corners: Cells


def crossed_by(info: GridInfo, points: NDArray[np.float64]) -> Crossed:
    """Return the cells that a path crosses.

    Between two cells that touch at a corner, a path runs inside both and the two cells beside them. These four cells
    cover it, so no crossed cell is missing.

    Parameters
    ----------
    info : GridInfo
        Geometry of the grid.
    points : (n, 2) array
        x, y [m], at least one.
    """
    cells = info.to_cells(points)
    strides = _strides(cells)
    if strides.max(initial=0) > 1:
        cells = info.to_cells(_densified(points, strides))
    moved = _strides(cells) > 0
    if not moved.all():
        cells = cells[np.concatenate(([True], moved))]
    rows, columns = cells[:, 0], cells[:, 1]
    diagonal = np.flatnonzero((rows[1:] != rows[:-1]) & (columns[1:] != columns[:-1]))
    corners = np.empty((2, len(diagonal), 2), np.int64)
    corners[0, :, 0], corners[0, :, 1] = rows[diagonal], columns[diagonal + 1]
    corners[1, :, 0], corners[1, :, 1] = rows[diagonal + 1], columns[diagonal]
    return Crossed(cells, corners.reshape(-1, 2))


def _strides(cells: Cells) -> NDArray[np.int64]:
    """Return the number of rows or columns of each step, whichever is larger."""
    rows, columns = cells[:, 0], cells[:, 1]
    strides: NDArray[np.int64] = np.maximum(np.abs(rows[1:] - rows[:-1]), np.abs(columns[1:] - columns[:-1]))
    return strides


def _densified(points: NDArray[np.float64], strides: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the points with more points between them; consecutive ones lie in the same cell or in neighbours."""
    # A step of n cells is shorter than n + 1 edges. Each of n + 2 pieces is shorter than an edge, despite rounding.
    pieces = strides + 2
    owner = np.repeat(np.arange(len(pieces)), pieces)
    first = np.cumsum(pieces) - pieces
    fraction = (np.arange(len(owner)) - first[owner]) / pieces[owner]
    steps = np.diff(points, axis=0)
    return np.concatenate((points[owner] + steps[owner] * fraction[:, None], points[-1:]))


def first_blocked(costmap: Costmap, crossed: Crossed, open_costs: NDArray[np.bool_]) -> tuple[int, int] | None:
    """Return row and column of a cell that the path must not cross, or None if all cells are free.

    Parameters
    ----------
    costmap : Costmap
        The current costmap.
    crossed : Crossed
        Cells of the path.
    open_costs : (256,) bool array
        Which costs may be crossed (``ppaas.planners.weights.passable``).
    """
    height, width = costmap.info.shape
    for cells in (crossed.cells, crossed.corners):
        rows, columns = cells[:, 0], cells[:, 1]
        inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
        if not inside.all():
            rows, columns = rows[~inside], columns[~inside]
            return int(rows[0]), int(columns[0])
        free = open_costs[costmap.data[rows, columns]]
        if not free.all():
            at = int(np.argmin(free))
            return int(rows[at]), int(columns[at])
    return None
