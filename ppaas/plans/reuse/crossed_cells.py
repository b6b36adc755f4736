"""Which cells a path crosses, however far apart its points lie, and whether a robot may cross them all now."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import GridInfo

Cells = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Crossed:
    """What a path crosses.

    Parameters
    ----------
    cells : (n, 2) int64 array
        Row, column from start to goal, each a neighbour of the one before.
    corners : (m, 2) int64 array
        Those beside its diagonal moves: they must be free as well.
    """

    cells: Cells
    corners: Cells


def crossed_by(info: GridInfo, points: NDArray[np.float64]) -> Crossed:
    """Return the cells that a path crosses.

    Where it goes from one cell to another that touches it at a corner, it runs within both and the two beside them.
    So these four hold all of it, and nothing that it crosses is left out.

    Parameters
    ----------
    info : GridInfo
        Where the cells lie.
    points : (n, 2) array
        x, y [m], at least one.
    """
    cells = info.to_cells(points)
    furthest = _furthest(cells)
    if furthest.max(initial=0) > 1:
        cells = info.to_cells(_closer(points, furthest))
    moved = _furthest(cells) > 0
    if not moved.all():
        cells = cells[np.concatenate(([True], moved))]
    rows, columns = cells[:, 0], cells[:, 1]
    diagonal = np.flatnonzero((rows[1:] != rows[:-1]) & (columns[1:] != columns[:-1]))
    corners = np.empty((2, len(diagonal), 2), np.int64)
    corners[0, :, 0], corners[0, :, 1] = rows[diagonal], columns[diagonal + 1]
    corners[1, :, 0], corners[1, :, 1] = rows[diagonal + 1], columns[diagonal]
    return Crossed(cells, corners.reshape(-1, 2))


def _furthest(cells: Cells) -> NDArray[np.int64]:
    """Return how many rows or columns each step goes, whichever is more."""
    rows, columns = cells[:, 0], cells[:, 1]
    furthest: NDArray[np.int64] = np.maximum(np.abs(rows[1:] - rows[:-1]), np.abs(columns[1:] - columns[:-1]))
    return furthest


def _closer(points: NDArray[np.float64], furthest: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the points with others between them, so that two after one another are in cells that touch."""
    # A line over so many cells is shorter than one more; by another, no piece is as long as an edge but for rounding.
    pieces = furthest + 2
    owner = np.repeat(np.arange(len(pieces)), pieces)
    first = np.cumsum(pieces) - pieces
    part = (np.arange(len(owner)) - first[owner]) / pieces[owner]
    steps = np.diff(points, axis=0)
    return np.concatenate((points[owner] + steps[owner] * part[:, None], points[-1:]))


def first_blocked(costmap: Costmap, crossed: Crossed, open_costs: NDArray[np.bool_]) -> tuple[int, int] | None:
    """Return a cell that a path may not cross, row and column, or None if it may cross all.

    Parameters
    ----------
    costmap : Costmap
        As it is now.
    crossed : Crossed
        By the path.
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
