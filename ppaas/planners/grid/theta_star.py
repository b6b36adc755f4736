"""Theta*: any-angle paths of straight lines, with a cost field as the heuristic."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Cell, Ends
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.grid.kernels.line_of_sight import trace
from ppaas.planners.grid.kernels.string_pulling import along, tauten
from ppaas.planners.grid.kernels.theta_star import COUNT, KNOWN, SIZE, STATE_SIZE, find
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.kernels.moves import PAUSED, SETTLED
from ppaas.planners.traits import Traits
from ppaas.planners.watch import proceed
from ppaas.planners.weights import NEUTRAL, SCALE, blocking_weights, neighbour_offsets, padded

# -- the search, with a cost field as the heuristic --------------------------------------------------------------------

SLICE_CELLS = 1_000
"""Cells popped between two checks, where long lines count as several: about 1 ms, or 3 ms if the memory is newly
allocated."""


class ThetaStarSearch:
    """One search for a path of straight lines.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    costs_to_go : (height, width) array
        Cost of moves from cell to cell to the goal; must be final in all cells that cost no more than the start.
    allow_unknown : bool
        Whether unknown cells may be crossed.
    check : callable
        Called at least every few milliseconds of work; an exception from it ends the work.
    """

    def __init__(
        self,
        costmap: Costmap,
        costs_to_go: NDArray[np.float64],
        allow_unknown: bool,
        check: Callable[[], None],
    ) -> None:
        self._check = check
        costs = padded(costmap.data, check)
        self._stride = costmap.info.width + 2
        self._costs = costs.ravel()
        self._weights = blocking_weights(allow_unknown)[0]
        self._offsets = neighbour_offsets(self._stride)
        self._toward = np.ascontiguousarray(costs_to_go)
        self.expanded = 0

    def corners(self, start: Cell, goal: Cell) -> NDArray[np.int64]:
        """Return the corners of a path, as elements of the padded map; the goal must be reachable."""
        size = self._costs.size
        begin, end = self._flat(start), self._flat(goal)
        value, parent, status = np.empty(size), np.empty(size, np.int32), np.zeros(size, np.uint8)
        keys, cells, places = np.empty((size, 2)), np.empty(size, np.int32), np.zeros(size, np.int32)
        state = np.zeros(STATE_SIZE, np.int64)
        value[begin], parent[begin], status[begin] = 0.0, begin, KNOWN
        keys[1], cells[1], places[begin], state[SIZE] = 0.0, begin, 1, 1
        outcome = PAUSED
        while outcome == PAUSED:
            self._check()
            outcome = find(
                self._costs, self._stride, self._weights, self._offsets, SCALE * NEUTRAL,
                self._toward, self._toward[start], value, parent, status,
                keys, cells, places, state, end, SLICE_CELLS,
            )  # fmt: skip
        assert outcome == SETTLED
        self.expanded = int(state[COUNT])
        found = [end]
        while found[-1] != begin:
            found.append(int(parent[found[-1]]))
        return np.array(found[::-1], np.int64)

    def tautened(self, corners: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the corners after string pulling: superfluous ones removed, the others moved to lower the cost."""
        count, at = len(corners), 1
        while at < count - 1:
            self._check()
            count, at = tauten(self._costs, self._stride, self._weights, self._offsets, corners, count, at)
        return corners[:count]

    def cost(self, corners: NDArray[np.int64]) -> float:
        """Return the integral of the weights along the lines."""
        return float(along(self._costs, self._stride, self._weights, corners, len(corners))) / SCALE

    def cells_of(self, corners: NDArray[np.int64]) -> NDArray[np.int32]:
        """Return the (n, 2) rows and columns of the map."""
        return np.stack((corners // self._stride - 1, corners % self._stride - 1), axis=1).astype(np.int32)

    def _flat(self, cell: Cell) -> int:
        return (cell[0] + 1) * self._stride + cell[1] + 1


def crossed(
    corners: NDArray[np.int32], check: Callable[[], None] = proceed
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return the cells and points on the straight lines between corners.

    Parameters
    ----------
    corners : (m, 2) array
        Row, column.
    check : callable
        Called between two lines; an exception from it ends the work.

    Returns
    -------
    cells : (n, 2) int32 array
        All crossed cells, each a neighbour of the one before.
    points : (n, 2) float64 array
        Row, column of the midpoint of the line within each cell; for a corner, the centre of its cell.
    """
    most = 1 + int(np.abs(np.diff(corners, axis=0)).sum())
    cells, points = np.empty((most, 2), np.int32), np.empty((most, 2))
    cells[0] = points[0] = corners[0]
    count = 1
    for corner, (down, right) in zip(corners, np.diff(corners, axis=0).tolist(), strict=False):
        check()
        ahead = count + trace(down, right, cells[count:], points[count:])
        cells[count:ahead] += corner
        points[count:ahead] += corner
        count = ahead
    return cells[:count].copy(), points[:count].copy()


# -- the planner -------------------------------------------------------------------------------------------------------


class ThetaStar(GridPlanner):
    """Plans paths of straight lines at any angle.

    The cost of a line is the integral of the weights of the cells that it crosses. Like moves from cell to cell, a line
    crosses no blocked cell, and where it passes the corner of four cells, all of them are free. Its ends are centres of
    cells. The plan takes three steps: the cost field of moves is grown; Lazy Theta* searches with the field as its
    heuristic (see `ppaas.planners.grid.kernels.theta_star`); and each corner is removed or moved as long as that lowers
    the cost.

    On a map of one cost the path is never longer than the shortest path of moves. It is not always the shortest path at
    any angle: no corner can be improved by moving it to a neighbouring cell, but a path on the other side of an
    obstacle may be shorter.
    """

    name: ClassVar[str] = "theta_star"
    purpose: ClassVar[str] = "Straight lines at any angle: shorter paths than moves from cell to cell give, few turns."
    traits: ClassVar[Traits] = Traits(any_angle=True)

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return a path; its cells are all that the lines between its corners cross."""
        field = CostField(
            costmap, np.array([ends.goal]), allow_unknown=self.allow_unknown, threads=threads, check=check
        )
        if not field.grow(ends.start):
            return Found(np.empty((0, 2), np.int32), field.settled)
        check()
        search = ThetaStarSearch(costmap, field.values(), self.allow_unknown, check)
        corners = search.tautened(search.corners(ends.start, ends.goal))
        cells, points = crossed(search.cells_of(corners), check)
        return Found(cells, field.settled + search.expanded, points, search.cost(corners))
