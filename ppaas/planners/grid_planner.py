"""Base of planners that search cells of a grid: it finds the ends, calls the search and makes the result."""

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import NoValidPath
from ppaas.planners.base import Planner, PlanRequest, PlanResult
from ppaas.planners.ends import Ends, place_ends
from ppaas.planners.path import path_cost, path_length, path_poses, poses_through
from ppaas.planners.smoothing import smooth_path
from ppaas.planners.watch import Watch


@dataclass(frozen=True, slots=True)
class Found:
    """Result of a search.

    Parameters
    ----------
    cells : (n, 2) int32 array
        Row, column from start to goal; empty if there is no path.
    expanded : int
        Number of cells whose value was settled.
    points : (m, 2) float64 array, optional
        Points of the path, if it does not run through the centres of the cells: row, column from start to goal, with
        fractions; whole numbers are centres.
    cost : float, optional
        Cost of the path, if it is not the sum of the weights of the moves.
    """

    cells: NDArray[np.int32]
    expanded: int
    points: NDArray[np.float64] | None = None
    cost: float | None = None


class GridPlanner(Planner):
    """Planner on the cells of a costmap; subclasses implement ``search``.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may cross unknown cells, which then weigh 253.
    smooth : bool
        Whether to smooth the poses of paths; cells and cost are unchanged.
    """

    def __init__(self, *, allow_unknown: bool = True, smooth: bool = False) -> None:
        self.allow_unknown = allow_unknown
        self.smooth = smooth

    @abstractmethod
    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells from ``ends.start`` to ``ends.goal``; must call ``check`` at least every 10 ms of work."""

    def plan(self, costmap: Costmap, request: PlanRequest) -> PlanResult:
        """Find a path.

        Raises
        ------
        InvalidInput
            A pose is not finite, or the tolerance or the timeout is negative.
        StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied, NoValidPath, PlanTimeout, PlanCancelled
        """
        watch = Watch(request)
        watch.check()
        ends = place_ends(costmap, request, allow_unknown=self.allow_unknown, check=watch.check)
        found = self.search(costmap, ends, threads=request.threads, check=watch.check)
        if not len(found.cells):
            raise NoValidPath(_no_path_message(request, ends))
        cells = np.concatenate((ends.escape, found.cells)) if len(ends.escape) else found.cells
        if found.points is None:
            poses = path_poses(costmap, cells, request.start, ends.goal_pose, threads=request.threads)
        else:
            points = np.concatenate((ends.escape.astype(np.float64), found.points))
            poses = poses_through(costmap, points, request.start, ends.goal_pose)
        if self.smooth:
            poses = smooth_path(costmap, poses, allow_unknown=self.allow_unknown, check=watch.check)
        return PlanResult(
            cells=cells,
            poses=poses,
            cost=_cost(costmap, cells, len(ends.escape), found),
            length=path_length(poses),
            expanded=found.expanded,
            seconds=watch.seconds(),
            planner=self.name,
        )


def _cost(costmap: Costmap, cells: NDArray[np.int32], escaped: int, found: Found) -> float:
    if found.cost is None:
        return path_cost(costmap, cells)
    return path_cost(costmap, cells[: escaped + 1]) + found.cost


def _no_path_message(request: PlanRequest, ends: Ends) -> str:
    return (
        f"no free path from x={request.start.x:.3f} y={request.start.y:.3f} to x={ends.goal_pose.x:.3f} "
        f"y={ends.goal_pose.y:.3f}; clear the costmap, or choose a goal that the robot can reach"
    )
