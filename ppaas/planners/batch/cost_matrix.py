"""Cost matrix: the path cost from each of many starts to each of many goals."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.batch.plan_many import Progress, no_progress
from ppaas.planners.batch.workers import Check, run_jobs
from ppaas.planners.ends import Ends, place_ends
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.field.start_field import StartField
from ppaas.planners.path import path_cost
from ppaas.planners.watch import proceed
from ppaas.planners.weights import exact_weights, passable

Cells = NDArray[np.int64]
Values = NDArray[np.float64]

START_FIELD_TAKES = 8
"""Time of a field grown from a start, relative to one grown from a goal, on one thread: 7 to 10 on graded costs."""

SLICE_COUNTED = 1 << 20
"""Cells counted between two checks."""


def cost_matrix(
    costmap: Costmap,
    starts: ArrayLike,
    goals: ArrayLike,
    *,
    threads: int = 1,
    allow_unknown: bool = True,
    check: Check = proceed,
    progress: Progress = no_progress,
) -> Values:
    """Return the cost of the cheapest path from each start to each goal.

    One cost field is grown for each goal, or for each start if that is less work, and only as far as needed.

    Parameters
    ----------
    costmap : Costmap
        Only read; it must not change meanwhile.
    starts : (n, 2) or (n, 3) array
        x, y [m] and optionally yaw [rad], which is ignored, in the frame of the costmap. As in a plan, a start that is
        not free is connected to the nearest free cell.
    goals : (m, 2) or (m, 3) array
        Goals, in the same form.
    threads : int
        Maximum number of threads.
    allow_unknown : bool
        Whether unknown cells may be entered.
    check : callable
        Called often, by several threads at once; an exception from it ends the work.
    progress : callable
        Called occasionally, in the caller's thread, with the number of finished fields and their total.

    Returns
    -------
    (n, m) float64 array
        ``PlanResult.cost`` of ``dijkstra``, with a relative error below `ppaas.planners.weights.RELATIVE_ERROR`;
        infinite if there is no path.

    Raises
    ------
    InvalidInput
        Poses have another shape or are not finite, or ``threads`` is below 1.
    StartOutsideMap, GoalOutsideMap, StartOccupied, GoalOccupied
    """
    if threads < 1:
        raise InvalidInput(f"threads must be at least 1, not {threads}")
    begins, ends = _poses(starts, "starts"), _poses(goals, "goals")
    if not begins or not ends:
        return np.empty((len(begins), len(ends)))

    def placed(start: Pose2D, goal: Pose2D) -> Ends:
        return place_ends(costmap, PlanRequest(start, goal), allow_unknown=allow_unknown, check=check)

    left = [placed(start, ends[0]) for start in begins]
    sources = np.array([each.start for each in left])
    aims = np.array([placed(begins[0], goal).goal for goal in ends])
    symmetric = _is_uniform(costmap, allow_unknown, check)
    fields = _Fields(costmap, allow_unknown, threads, check, progress)
    if len(ends) <= len(begins) * (1 if symmetric else START_FIELD_TAKES):
        values = fields.rows(aims, sources, of_starts=False).T
    else:
        values = fields.rows(sources, aims, of_starts=not symmetric)
    values += np.array([_escape_cost(costmap, each) for each in left])[:, np.newaxis]
    return values


def _poses(given: ArrayLike, what: str) -> list[Pose2D]:
    try:
        poses = np.asarray(given, dtype=np.float64)
    except ValueError as error:
        raise InvalidInput(f"{what} must be rows of x, y [m] and optionally yaw [rad], all of one length") from error
    if poses.size == 0:
        return []
    if poses.ndim != 2 or poses.shape[1] not in (2, 3):
        raise InvalidInput(
            f"{what} must be rows of x, y [m] and optionally yaw [rad], not an array of shape {poses.shape}"
        )
    if not np.isfinite(poses).all():
        raise InvalidInput(f"{what} must be finite numbers")
    return [Pose2D(*pose) for pose in poses.tolist()]


def _escape_cost(costmap: Costmap, ends: Ends) -> float:
    """Return the cost from the robot's cell to the free cell where its path begins."""
    return path_cost(costmap, np.concatenate((ends.escape, np.array([ends.start], np.int32))))


def _is_uniform(costmap: Costmap, allow_unknown: bool, check: Check) -> bool:
    """Return whether all free cells weigh the same, so that a path costs the same in both directions."""
    found = np.zeros(256, np.bool_)
    rows = max(1, SLICE_COUNTED // costmap.info.width)
    for first in range(0, costmap.info.height, rows):
        check()
        found |= np.bincount(costmap.data[first : first + rows].ravel(), minlength=256) > 0
    return len(np.unique(exact_weights()[found & passable(allow_unknown)])) < 2


@dataclass(frozen=True, slots=True)
class _Fields:
    """The fields of one cost matrix; each is grown by one thread."""

    costmap: Costmap
    allow_unknown: bool
    threads: int
    check: Check
    progress: Progress

    def rows(self, sources: Cells, wanted: Cells, *, of_starts: bool) -> Values:
        """Return the (k, l) values at the (l, 2) cells ``wanted`` of the fields of the (k, 2) cells ``sources``."""
        cells, which = np.unique(sources, axis=0, return_inverse=True)
        crew = min(self.threads, len(cells))
        grow = self._of_start if of_starts else self._of_goal
        done = 0

        def work(cell: Cells, check: Check) -> Values:
            return grow(cell, wanted, self.threads // crew, check)

        def report(_: Cells) -> None:
            nonlocal done
            done += 1
            self.progress(done, len(cells))

        rows = run_jobs([work] * crew, list(cells), check=self.check, done=report)
        return np.stack(rows)[which.ravel()]

    def _of_goal(self, goal: Cells, wanted: Cells, threads: int, check: Check) -> Values:
        cells, unknown = goal[np.newaxis], self.allow_unknown
        field = CostField(self.costmap, cells, allow_unknown=unknown, threads=threads, check=check)
        for row, column in wanted.tolist():
            field.grow((row, column))
        return field.values_at(wanted)

    def _of_start(self, start: Cells, wanted: Cells, _threads: int, check: Check) -> Values:
        row, column = start.tolist()
        return StartField(self.costmap, (row, column), allow_unknown=self.allow_unknown, check=check).grow(wanted)
