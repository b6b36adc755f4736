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
    furthest = np.abs(np.diff(cells, axis=0)).max(axis=1, initial=0)
    if furthest.size and furthest.max() > 1:
        cells = info.to_cells(_closer(points, furthest))
    moved = np.ones(len(cells), np.bool_)
    np.any(np.diff(cells, axis=0), axis=1, out=moved[1:])
    cells = cells[moved]
    before, after = cells[:-1], cells[1:]
    diagonal = np.all(before != after, axis=1)
    before, after = before[diagonal], after[diagonal]
    beside = (np.stack((before[:, 0], after[:, 1]), axis=1), np.stack((after[:, 0], before[:, 1]), axis=1))
    return Crossed(cells, np.concatenate(beside))


def _closer(points: NDArray[np.float64], furthest: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the points with others between them, so that two after one another are in cells that touch."""
    pieces = furthest + 1  # a cell more than lies between, so that no piece is longer than an edge
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
    for cells in (crossed.cells, crossed.corners):
        if not len(cells):
            continue
        outside = np.any((cells < 0) | (cells >= costmap.info.shape), axis=1)
        blocked = outside.copy()
        blocked[~outside] = ~open_costs[costmap.data[tuple(cells[~outside].T)]]
        if blocked.any():
            row, column = cells[int(np.argmax(blocked))].tolist()
            return row, column
    return None
