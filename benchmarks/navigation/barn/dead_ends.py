"""Places at which the robot got no farther, though its plan led on: plans keep out of them from then on."""

import math

import numpy as np

from ppaas.costmap.costmap import NO_INFORMATION, Costmap
from ppaas.costmap.moving_obstacles import Disc
from ppaas.geometry import Pose2D, Poses
from ppaas.navigation.oscillation import Oscillation

DISTANCE, TIMEOUT = 0.4, 2.0
"""It gets no farther if it has not moved so far [m] in so long [s]."""
NEAR, AHEAD = 0.55, 1.2
"""How far off on the plan the narrowest place is looked for [m]; what is shut must leave the robot room to turn."""
RADIUS = 0.15
"""Of the disc that shuts it [m]."""
STEP, BESIDE = 0.1, 0.3
"""How far apart the places are that it remembers to have come through, and how near to one nothing is shut [m]."""


class DeadEnds:
    """Watches whether the robot gets on, and shuts the narrowest place ahead where it does not.

    Attributes
    ----------
    discs : list of (x, y, radius)
        What is shut, in the frame of the plan [m].
    """

    def __init__(self) -> None:
        self.discs: list[Disc] = []
        self._watch = Oscillation(DISTANCE, TIMEOUT)
        self._trail: list[tuple[float, float]] = []

    def look(self, now: float, pose: Pose2D, plan: Poses, costs: Costmap) -> bool:
        """Tell whether a place was shut, since the robot at ``pose`` got no farther.

        Parameters
        ----------
        now : float
            [s].
        pose : Pose2D
        plan : (n, 7) array
            That it follows.
        costs : Costmap
            Around it.
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
        """Open all that was shut."""
        self.discs.clear()

    def _remember(self, pose: Pose2D) -> None:
        if not self._trail or math.dist(self._trail[-1], (pose.x, pose.y)) >= STEP:
            self._trail.append((pose.x, pose.y))

    def _untried(self, plan: Poses) -> Poses:
        """Return what of a plan lies where the robot has not been: on the way back out, it is slow to turn round."""
        away = plan[:, None, :2] - np.array(self._trail)
        untried: Poses = plan[np.hypot(away[..., 0], away[..., 1]).min(axis=1) > BESIDE]
        return untried


def _narrowest(pose: Pose2D, plan: Poses, costs: Costmap) -> tuple[float, float] | None:
    """Return x, y of the dearest cell that the plan leads through next."""
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
