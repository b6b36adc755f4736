"""Plan that a robot follows, and the robot's progress along it."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, Poses, yaw_of

Floats = NDArray[np.float64]

SEARCH_AHEAD = 1.0
"""Length of the plan ahead of the last position in which the robot is searched, so that no loop is skipped [m]."""

LOST = 1.0
"""Distance from the plan above which the robot is searched along the whole plan [m]."""

SPACING = 0.05
"""Distance between points of `FollowedPath.ahead` [m], larger if there would be more than `MOST_POINTS`."""

MOST_POINTS = 64


class FollowedPath:
    """Plan with arc lengths.

    Parameters
    ----------
    poses : (n, 7) array
        At least one row.

    Raises
    ------
    InvalidInput
        The array is empty, has another shape, or is not finite.
    """

    def __init__(self, poses: Poses) -> None:
        poses = np.asarray(poses, dtype=np.float64)
        if poses.ndim != 2 or poses.shape[1] != 7 or not len(poses):
            raise InvalidInput(f"a plan must have shape (n, 7) with at least one row, not {poses.shape}")
        if not np.isfinite(poses).all():
            raise InvalidInput("the numbers of a plan must be finite")
        self._points: Floats = poses[:, :2].copy()
        steps = np.diff(self._points, axis=0)
        self._along: Floats = np.concatenate(([0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))))
        self._reached = 0
        x, y, _, qx, qy, qz, qw = poses[-1].tolist()
        self.end = Pose2D(x, y, yaw_of(qx, qy, qz, qw))

    def locate(self, pose: Pose2D) -> None:
        """Update the robot's position along the plan: searched ahead of the last one, and everywhere if that fails."""
        before = -1
        while self._reached > before:
            before = self._reached
            last = int(np.searchsorted(self._along, self._along[before] + SEARCH_AHEAD, side="right"))
            self._reached, distance = self._nearest(pose, before, last)
        if distance > LOST:
            self._reached, _ = self._nearest(pose, 0, len(self._points))

    @property
    def lengths(self) -> Floats:
        """Distance of each pose from the first, along the plan [m]."""
        return self._along

    @property
    def reached(self) -> int:
        """Index of the pose at which the robot was located."""
        return self._reached

    def to_go(self, pose: Pose2D) -> float:
        """Return the remaining distance to the end of the plan [m]."""
        here = self._points[self._reached]
        along = float(self._along[-1] - self._along[self._reached])
        return max(pose.distance_to(self.end), along - math.hypot(here[0] - pose.x, here[1] - pose.y))

    def point_ahead(self, distance: float) -> tuple[float, float]:
        """Return the point of the plan ``distance`` [m] ahead of the robot, or its end."""
        s = self._along[self._reached] + distance
        x, y = (float(np.interp(s, self._along, self._points[:, axis])) for axis in (0, 1))
        return x, y

    def ahead(self, distance: float, costmap: Costmap) -> tuple[Floats, Floats]:
        """Return the plan from the robot to ``distance`` [m] ahead, or to the edge of the costmap.

        Returns
        -------
        points : (m, 2) array
            x, y [m], evenly spaced.
        remaining : (m,) array
            Distance from each point to the last, along the plan [m].
        """
        first = max(0.0, self._along[self._reached] - SPACING)
        last = min(self._along[-1], self._along[self._reached] + distance)
        count = min(MOST_POINTS, 2 + int((last - first) / SPACING))
        s = np.linspace(first, last, count)
        points = np.stack([np.interp(s, self._along, self._points[:, axis]) for axis in (0, 1)], axis=-1)
        cells = costmap.info.to_cells(points)
        outside = ((cells < 0) | (cells >= costmap.info.shape)).any(axis=1)
        inside = int(np.argmax(outside)) if outside.any() else count
        points, s = points[: max(1, inside)], s[: max(1, inside)]
        return points, s[-1] - s

    def _nearest(self, pose: Pose2D, first: int, last: int) -> tuple[int, float]:
        offsets = self._points[first:last] - (pose.x, pose.y)
        distances = np.hypot(offsets[:, 0], offsets[:, 1])
        nearest = int(np.argmin(distances))
        return first + nearest, float(distances[nearest])
