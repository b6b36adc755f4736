"""Where plans were found blocked on the way: waited for, then shut, so that no robot runs to and fro between two ways.

A gap that is as wide as the robot by a hair is open in one scan and shut in the next, and people come and go. So a
detour is not taken before the shorter way has been waited for, about as long as the detour takes. Who turns to another
way must keep to that way, though the first is free again as soon as nobody looks.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.discs import stamp_disc
from ppaas.planners.base import PlanResult

LONGER = 1.0
"""A plan that is longer than what is left of the one before by more than this, and a tenth, leads another way [m]."""
WAIT = 10.0
"""For how long a way that is shut is waited for at most [s]; less, a second for each metre, where that saves less."""
FIRST, LONGEST = 30.0, 240.0
"""For how long a place is shut, twice as long each time that it is found so again [s]."""
RADIUS = 0.3
"""Of what is shut around each blocked point of a plan [m]."""
FOLLOWED = 1.0
"""A goal that is no farther from the one before is that one, which moved: the way there is the same [m]."""
CLEAR = 0.6
"""Nothing is shut nearer than this to the robot, or to its goal [m]."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where it is shut, (n, 2) row, column; until when, and for how long it was said to be [s]."""

    cells: NDArray[np.int64]
    until: float
    seconds: float


class ShutPlaces:
    """What was found shut on the way to one goal, which may move."""

    def __init__(self) -> None:
        self._goal: Pose2D | None = None
        self._plan: PlanResult | None = None
        self._blocked_since = math.inf
        self._places: list[Place] = []

    def head_for(self, goal: Pose2D) -> None:
        """Take the goal from now on; forget all if it is another than before."""
        before, self._goal = self._goal, goal
        if before is None or before.distance_to(goal) > FOLLOWED:
            self._plan, self._blocked_since = None, math.inf
            self._places.clear()

    def mark(self, costmap: Costmap, now: float) -> Costmap:
        """Return a costmap in which what is shut now is occupied; what was given is not written to."""
        places = [place for place in self._places if now < place.until]
        if not places:
            return costmap
        data = costmap.data.copy()
        radius = RADIUS / costmap.info.resolution
        for place in places:
            for row, column in place.cells.tolist():
                stamp_disc(data, column + 0.5, row + 0.5, radius, LETHAL_OBSTACLE)
        return Costmap(data, costmap.info, costmap.indexes)

    def take(self, plan: object, costmap: Costmap, pose: Pose2D, now: float) -> float:
        """Take what a planner found; where it leads another way, the one that is followed was shut somewhere.

        Parameters
        ----------
        plan : PlanResult or object
            Anything else is no plan: with no way left, nothing is shut any more.
        costmap : Costmap
            On which it was made.
        pose : Pose2D
            Of the robot.
        now : float
            [s].

        Returns
        -------
        float
            0: the plan is to be followed. Else it is a detour of so many metres, which is not to be taken yet.
        """
        if not isinstance(plan, PlanResult):
            self._places.clear()
            self._blocked_since = min(self._blocked_since, now)
            return 0.0
        if self._plan is not None:
            rest, length = _rest(self._plan, costmap, pose)
            blocked = _blocked(rest, costmap)
            longer = plan.length - length
            if len(blocked) and longer > max(LONGER, 0.1 * length):
                self._blocked_since = min(self._blocked_since, now)
                if now - self._blocked_since < min(WAIT, longer):
                    return longer
                self._shut(blocked, (costmap.info.to_cells(pose[:2]), rest[-1]), now, costmap.info.resolution)
        self._plan, self._blocked_since = plan, math.inf
        return 0.0

    def _shut(
        self, cells: NDArray[np.int64], ends: tuple[NDArray[np.int64], ...], now: float, resolution: float
    ) -> None:
        """Shut cells of a plan, but for those that are near to its ends."""
        for end in ends:
            cells = cells[np.hypot(*(cells - end).T) * resolution > CLEAR]
        if not len(cells):
            return
        for index, place in enumerate(self._places):
            if np.hypot(*(place.cells[0] - cells[0])) * resolution < 2.0 * RADIUS:
                seconds = min(2.0 * place.seconds, LONGEST)
                self._places[index] = replace(place, cells=cells, until=now + seconds, seconds=seconds)
                return
        self._places.append(Place(cells, now + FIRST, FIRST))


def _rest(plan: PlanResult, costmap: Costmap, pose: Pose2D) -> tuple[NDArray[np.int64], float]:
    """Return the cells of a plan that are still to go, and how long that is [m]."""
    apart = np.hypot(*(plan.cells - costmap.info.to_cells(pose[:2])).T)
    rest = plan.cells[int(np.argmin(apart)) :].astype(np.int64)
    steps = np.abs(np.diff(rest, axis=0)).sum(axis=1)
    return rest, float(np.sqrt(steps).sum()) * costmap.info.resolution


def _blocked(rest: NDArray[np.int64], costmap: Costmap) -> NDArray[np.int64]:
    """Return the cells of a way in which the robot would touch something."""
    costs = costmap.data[rest[:, 0], rest[:, 1]]
    blocked: NDArray[np.int64] = rest[(costs >= INSCRIBED_INFLATED_OBSTACLE) & (costs != NO_INFORMATION)]
    return blocked
