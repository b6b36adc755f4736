"""Progress of a robot towards the places that were chosen for it."""

import math

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.people.talking_groups import Points

STUCK = 5.0
"""Time without progress after which a place counts as not reachable [s]."""

MOVED, SAME = 0.15, 0.5
"""Distance that counts as progress, and distance up to which a place is the one of before [m]."""

REACHED = 0.3
"""Distance from a place within which the robot has reached it [m]."""

FORGOTTEN = 20.0
"""Time for which a place that was not reached is avoided [s]."""

MOST_FAILURES = 3


class Progress:
    """Notes places that the robot does not get to.

    Attributes
    ----------
    failures : int
        Number of places not reached since the robot last stood well.
    most : int
        Number of them that are tried.
    """

    def __init__(self) -> None:
        self.failures, self.most = 0, MOST_FAILURES
        self._failed: list[tuple[float, float, float]] = []
        self._place: Pose2D | None = None
        self._from, self._since = Pose2D(0.0, 0.0), 0.0

    def rest(self) -> None:
        """Note that the robot stands on purpose."""
        self._place = None

    def reset(self) -> None:
        """Note that the robot has got to where it should be."""
        self.failures, self._place = 0, None

    def is_stuck(self, now: float, robot: Pose2D, place: Pose2D) -> bool:
        """Return whether the robot makes no progress to a place, which is avoided from then on."""
        other = self._place is None or self._place.distance_to(place) > SAME
        if other or robot.distance_to(self._from) > MOVED or robot.distance_to(place) <= REACHED:
            self._from, self._since = robot, now
            self._place = place
            return False
        self._place = place
        if now - self._since <= STUCK:
            return False
        self.fail(now)
        return True

    def fail(self, now: float) -> int:
        """Avoid the last place from now on; return how many places were not reached."""
        place, self._place = self._place, None
        if place is not None:
            self._failed.append((place.x, place.y, now + FORGOTTEN))
        self.failures += 1
        return self.failures

    def failed(self, now: float) -> Points:
        """Return the places to avoid, (n, 2) x, y [m]."""
        self._failed = [each for each in self._failed if math.isfinite(each[2]) and now < each[2]]
        return np.array([each[:2] for each in self._failed]).reshape(-1, 2)
