"""Filter of the pose of a dock, as it is seen again and again."""

import math

from ppaas.geometry import Pose2D, wrap_angle

ENOUGH = 3
"""Number of poses that agree, from which a filtered pose is known."""

FAR, TURNED = 0.12, 0.35
"""Differences beyond which a pose does not agree with the filtered one [m, rad]."""

DOUBTS = 5
"""Number of poses in a row that do not agree with the filtered one, but with each other, which replace it."""

SLOWEST = 0.2
"""Least weight of a new pose."""


class DockPoseFilter:
    """Mean of the poses that agree; single wrong ones change nothing, and a dock that is elsewhere is followed.

    Attributes
    ----------
    seen_at : float
        Time of the last pose that agrees [s].
    """

    def __init__(self) -> None:
        self.seen_at = -math.inf
        self._mean: Pose2D | None = None
        self._count = 0
        self._other: Pose2D | None = None
        self._doubts = 0

    @property
    def pose(self) -> Pose2D | None:
        """The filtered pose; None as long as too few poses agree."""
        return self._mean if self._count >= ENOUGH else None

    @property
    def guess(self) -> Pose2D | None:
        """The filtered pose, even if few poses agree."""
        return self._mean

    def take(self, pose: Pose2D, now: float) -> None:
        """Take a pose that is seen at a time [s]."""
        if self._mean is None or _agrees(self._mean, pose):
            self._count += 1
            self._doubts, self._other, self.seen_at = 0, None, now
            self._mean = _mean_of(self._mean or pose, pose, max(1.0 / self._count, SLOWEST))
            return
        agrees = self._other is not None and _agrees(self._other, pose)
        self._doubts = self._doubts + 1 if agrees else 1
        self._other = pose
        if self._doubts >= DOUBTS:
            self._mean, self._count, self._doubts, self.seen_at = pose, ENOUGH, 0, now


def _agrees(one: Pose2D, other: Pose2D) -> bool:
    return one.distance_to(other) <= FAR and abs(wrap_angle(one.theta - other.theta)) <= TURNED


def _mean_of(mean: Pose2D, pose: Pose2D, weight: float) -> Pose2D:
    return Pose2D(
        mean.x + weight * (pose.x - mean.x),
        mean.y + weight * (pose.y - mean.y),
        wrap_angle(mean.theta + weight * wrap_angle(pose.theta - mean.theta)),
    )
