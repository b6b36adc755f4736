"""Memory of blocked paths, which keeps a robot from oscillating between two routes.

A gap hardly wider than the robot looks open in one scan and closed in the next, and people come and go. So before
taking a detour, the robot waits about as long as the detour would take. Once on the detour it stays there: the places
that blocked the first route are closed in its costmap for a while, even if they look free when no sensor sees them.
"""

import math
from dataclasses import dataclass, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.discs import stamp_disc
from ppaas.maps.grid import GridInfo
from ppaas.planners.base import PlanResult

LONGER = 1.0
"""A new plan is a detour if it is longer than the rest of the last one by more than this and by a tenth [m]."""

WAIT = 10.0
"""Longest time to wait for a blocked path [s]; one second per metre of the detour if that is less."""

FIRST, LONGEST = 30.0, 240.0
"""Time for which a place is closed at first, and at most; doubled each time it is found blocked again [s]."""

RADIUS = 0.3
"""Radius of the disc that is closed around each blocked cell of a plan [m]."""

FOLLOWED = 1.0
"""Distance up to which a new goal counts as the old one, which has moved [m]."""

CLEAR = 0.6
"""Distance to the robot and to its goal within which nothing is closed [m]."""


@dataclass(frozen=True, slots=True)
class BlockedPath:
    """Blocked part of a path.

    Parameters
    ----------
    cells : (n, 2) array
        row, column of the cells that are closed.
    until : float
        End of the closure [s].
    seconds : float
        Duration of the closure [s].
    """

    cells: NDArray[np.int64]
    until: float
    seconds: float


class BlockedPathMemory:
    """Blocked paths to one goal, which may move."""

    def __init__(self) -> None:
        self._goal: Pose2D | None = None
        self._plan: PlanResult | None = None
        self._blocked_since = math.inf
        self._places: list[BlockedPath] = []

    def head_for(self, goal: Pose2D) -> None:
        """Set the goal; forget all blocked paths if it is another one than before."""
        before, self._goal = self._goal, goal
        if before is None or before.distance_to(goal) > FOLLOWED:
            self._plan, self._blocked_since = None, math.inf
            self._places.clear()

    def carry(self, before: GridInfo, static: Costmap) -> None:
        """Continue after the map was replaced; closed places outside the new map are forgotten.

        If the last plan is blocked by the new map, which will not become free, no detour is deferred for it.

        Parameters
        ----------
        before : GridInfo
            Geometry of the last map.
        static : Costmap
            Costmap of the new map alone.
        """
        if self._plan is not None:
            moved = _moved(self._plan.cells, before, static.info)
            holds = len(moved) == len(self._plan.cells) and not len(_blocked(moved, static))
            self._plan = msgspec.structs.replace(self._plan, cells=moved.astype(np.int32)) if holds else None
        if before != static.info:
            places = [replace(place, cells=_moved(place.cells, before, static.info)) for place in self._places]
            self._places = [place for place in places if len(place.cells)]

    def mark(self, costmap: Costmap, now: float) -> Costmap:
        """Return a copy of a costmap in which closed places are occupied, or the costmap itself if there are none."""
        places = [place for place in self._places if now < place.until]
        if not places:
            return costmap
        radius = RADIUS / costmap.info.resolution
        margin = math.ceil(radius) + 1
        marked = costmap.copied(*(costmap.window_around(place.cells, margin) for place in places))
        for place in places:
            for row, column in place.cells.tolist():
                stamp_disc(marked.data, column + 0.5, row + 0.5, radius, LETHAL_OBSTACLE)
        return marked

    def take(self, plan: object, costmap: Costmap, pose: Pose2D, now: float) -> float:
        """Check whether a new plan is a detour around a blocked part of the last plan.

        Parameters
        ----------
        plan : PlanResult or object
            The new plan. Anything else means that there is none; then all closed places are opened.
        costmap : Costmap
            Costmap on which it was made.
        pose : Pose2D
            Pose of the robot.
        now : float
            Current time [s].

        Returns
        -------
        float
            0 if the robot should follow the plan; otherwise the length of a detour that it should not take yet [m].
        """
        if not isinstance(plan, PlanResult):
            self._places.clear()
            self._blocked_since = min(self._blocked_since, now)
            return 0.0
        if self._plan is not None:
            rest, length = _rest(self._plan, costmap, pose)
            blocked = _blocked(rest, costmap)
            moved = float(np.hypot(*(plan.cells[-1] - self._plan.cells[-1]))) * costmap.info.resolution
            longer = plan.length - length - moved  # a goal that moves away is no detour
            if len(blocked) and longer > max(LONGER, 0.1 * length):
                self._blocked_since = min(self._blocked_since, now)
                if now - self._blocked_since < min(WAIT, longer):
                    return longer
                self._close(blocked, (costmap.info.to_cells(pose[:2]), rest[-1]), now, costmap.info.resolution)
        self._plan, self._blocked_since = plan, math.inf
        return 0.0

    def _close(
        self, cells: NDArray[np.int64], ends: tuple[NDArray[np.int64], ...], now: float, resolution: float
    ) -> None:
        """Close cells of a plan, except those near its ends."""
        for end in ends:
            cells = cells[np.hypot(*(cells - end).T) * resolution > CLEAR]
        if not len(cells):
            return
        for index, place in enumerate(self._places):
            if np.hypot(*(place.cells[0] - cells[0])) * resolution < 2.0 * RADIUS:
                seconds = min(2.0 * place.seconds, LONGEST)
                self._places[index] = replace(place, cells=cells, until=now + seconds, seconds=seconds)
                return
        self._places.append(BlockedPath(cells, now + FIRST, FIRST))


def _moved(cells: NDArray[np.integer], before: GridInfo, after: GridInfo) -> NDArray[np.int64]:
    """Return the cells of a grid that contain the centres of cells of another; those outside are left out."""
    moved = after.to_cells(before.to_world(cells))
    inside = np.logical_and(moved >= 0, moved < after.shape)
    return moved[np.logical_and.reduce(inside, axis=1)]


def _rest(plan: PlanResult, costmap: Costmap, pose: Pose2D) -> tuple[NDArray[np.int64], float]:
    """Return the remaining cells of a plan, and their length [m]."""
    apart = np.hypot(*(plan.cells - costmap.info.to_cells(pose[:2])).T)
    rest = plan.cells[int(np.argmin(apart)) :].astype(np.int64)
    steps = np.abs(np.diff(rest, axis=0)).sum(axis=1)
    return rest, float(np.sqrt(steps).sum()) * costmap.info.resolution


def _blocked(rest: NDArray[np.int64], costmap: Costmap) -> NDArray[np.int64]:
    """Return the cells in which the robot would touch something."""
    costs = costmap.data[rest[:, 0], rest[:, 1]]
    blocked: NDArray[np.int64] = rest[(costs >= INSCRIBED_INFLATED_OBSTACLE) & (costs != NO_INFORMATION)]
    return blocked
