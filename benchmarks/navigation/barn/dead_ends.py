"""Blocked places: if the robot makes no progress, the narrowest place ahead is blocked for later plans."""

import math

import numpy as np

from ppaas.costmap.costmap import NO_INFORMATION, Costmap
from ppaas.costmap.moving_obstacles import Disc
from ppaas.geometry import Pose2D, Poses
from ppaas.navigation.move_base import Oscillation

DISTANCE, TIMEOUT = 0.4, 2.0
"""The robot makes no progress if it has not moved this distance [m] within this time [s]."""
NEAR, AHEAD = 0.55, 1.2
"""Range of distances in which the narrowest place of the plan is sought [m]; closer, the robot needs space to turn."""
RADIUS = 0.15
"""Radius of a blocked disc [m]."""
STEP, BESIDE = 0.1, 0.3
"""Spacing of the recorded positions of the robot, and distance around each within which nothing is blocked [m]."""


class DeadEnds:
    """Checks the robot's progress, and blocks the narrowest place ahead if there is none.

    Attributes
    ----------
    discs : list of (x, y, radius)
        Blocked discs in the frame of the plan [m].
    """

    def __init__(self) -> None:
        self.discs: list[Disc] = []
        self._watch = Oscillation(DISTANCE, TIMEOUT)
        self._trail: list[tuple[float, float]] = []

    def look(self, now: float, pose: Pose2D, plan: Poses, costs: Costmap) -> bool:
        """Block a place if the robot makes no progress; return whether a place was blocked.

        Parameters
        ----------
        now : float
            Current time [s].
        pose : Pose2D
            Pose of the robot.
        plan : (n, 7) array
            Poses of the current plan.
        costs : Costmap
            Local costmap.
        """
        self._remember(pose)
        self._watch.has_left(now, pose)
        if not self._watch.timed_out(now):
            return False
        self._watch.reset(now)
        place = _narrowest(pose, self._untried(plan), costs)
        if place is not None:
            self.discs.append((*place, RADIUS))
        return place is not None

    def forget(self) -> None:
        """Unblock all places."""
        self.discs.clear()

    def _remember(self, pose: Pose2D) -> None:
        if not self._trail or math.dist(self._trail[-1], (pose.x, pose.y)) >= STEP:
            self._trail.append((pose.x, pose.y))

    def _untried(self, plan: Poses) -> Poses:
        """Return the poses of a plan away from the robot's path: a slow turn on the way back is not a dead end."""
        away = plan[:, None, :2] - np.array(self._trail)
        untried: Poses = plan[np.hypot(away[..., 0], away[..., 1]).min(axis=1) > BESIDE]
        return untried


def _narrowest(pose: Pose2D, plan: Poses, costs: Costmap) -> tuple[float, float] | None:
    """Return x, y [m] of the plan's most expensive cell between ``NEAR`` and ``AHEAD``; None without one."""
    if not len(plan):
        return None
    away = np.hypot(plan[:, 0] - pose.x, plan[:, 1] - pose.y)
    nearest = int(np.argmin(away))
    ahead = plan[nearest:][(away[nearest:] > NEAR) & (away[nearest:] < AHEAD)]
    cells = costs.info.to_cells(ahead[:, :2])
    inside = ((cells >= 0) & (cells < costs.info.shape)).all(axis=1)
    cells, ahead = cells[inside], ahead[inside]
    if not len(cells):
        return None
    dear = costs.data[cells[:, 0], cells[:, 1]].astype(np.int64)
    dear[dear == NO_INFORMATION] = 0
    x, y = ahead[int(np.argmax(dear)), :2].tolist()
    return x, y
