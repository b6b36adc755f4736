"""Lengths of shortest paths between many places, from an index of the map."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.ends import Cell, free_cell_near
from ppaas.planners.hub_labels.planner import HubLabels
from ppaas.planners.kernels.path_poses import add_costs
from ppaas.planners.prepared import Prepared
from ppaas.planners.watch import proceed
from ppaas.planners.weights import passable

NEAR = 0.5
"""Distance up to which a place that is not free is moved to a free cell [m]."""

_LENGTHS = np.ones(256)

Cells = NDArray[np.int32]


class PathLengths:
    """Paths between places on a map, and their lengths. Only one thread may use it at once.

    Parameters
    ----------
    costmap : Costmap
        Read-only.
    planner : HubLabels, optional
        Planner that may have the index of the costmap already.
    threads : int
        Largest number of threads that build the index.
    check : callable
        Called often while the index is built; an exception from it ends the work.
    """

    def __init__(
        self,
        costmap: Costmap,
        planner: HubLabels | None = None,
        *,
        threads: int = 1,
        check: Callable[[], None] = proceed,
    ) -> None:
        self.costmap = costmap
        planner = planner or HubLabels()
        self._open = passable(planner.allow_unknown)
        self._index: Prepared = planner.prepared(costmap, threads=threads, check=check)
        self._path = self._index.path
        self._zeros = np.zeros(0, np.uint8)

    def cell(self, x: float, y: float, near: float = NEAR) -> Cell | None:
        """Return the free cell of a place [m], or the nearest one within ``near`` [m]; None if there is none."""
        cell = self.costmap.info.cell_of(x, y)
        if cell is None or self._open[self.costmap.data[cell]]:
            return cell
        pose = Pose2D(x, y)
        try:
            return free_cell_near(self.costmap, PlanRequest(pose, pose, near), self._open)
        except (GoalOccupied, GoalOutsideMap):
            return None

    def path(self, start: Cell, goal: Cell) -> Cells:
        """Return the (n, 2) cells of a shortest path; empty if there is none."""
        return self._path(*start, *goal)

    def length(self, cells: Cells) -> float:
        """Return the length of a path along its cells [m]; infinite if it is empty."""
        count = len(cells)
        if not count:
            return float("inf")
        if count > len(self._zeros):
            self._zeros = np.zeros(2 * count, np.uint8)
        return self.costmap.info.resolution * add_costs(cells, self._zeros[:count], _LENGTHS)

    def between(
        self, starts: Sequence[Cell | None], goals: Sequence[Cell | None], check: Callable[[], None] = proceed
    ) -> NDArray[np.float64]:
        """Return the (n, m) lengths from each start to each goal [m]; infinite if there is no path, or no cell."""
        lengths = np.full((len(starts), len(goals)), np.inf)
        for row, start in enumerate(starts):
            check()
            for column, goal in enumerate(goals):
                if start is not None and goal is not None:
                    lengths[row, column] = self.length(self.path(start, goal))
        return lengths
