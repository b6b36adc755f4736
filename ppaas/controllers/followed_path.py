"""The plan a robot follows: where it is along it, and what lies ahead."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, Poses, yaw_of

Floats = NDArray[np.float64]

SEARCH_AHEAD = 1.0
"""How far along the plan the robot is looked for from where it was [m]; so it skips no loop of the plan."""
LOST = 1.0
"""Further than this from where it was looked for, it is looked for along the whole plan [m]."""
SPACING = 0.05
MOST_POINTS = 64


class FollowedPath:
    """A plan with arc lengths.

    Parameters
    ----------
    poses : (n, 7) array
        At least one.

    Raises
    ------
    InvalidInput
        No pose, another shape, or not finite.
    """

    def __init__(self, poses: Poses) -> None:
        poses = np.asarray(poses, dtype=np.float64)
        if poses.ndim != 2 or poses.shape[1] != 7 or not len(poses):
            raise InvalidInput(f"a plan is an array of one or more rows of 7, not of shape {poses.shape}")
        if not np.isfinite(poses).all():
            raise InvalidInput("a plan must be finite")
        self._points: Floats = poses[:, :2].copy()
        steps = np.diff(self._points, axis=0)
        self._along: Floats = np.concatenate(([0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))))
        self._reached = 0
        x, y, _, qx, qy, qz, qw = poses[-1].tolist()
        self.end = Pose2D(x, y, yaw_of(qx, qy, qz, qw))

    def locate(self, pose: Pose2D) -> None:
        """Note how far the robot has come; from there it is looked for further on, and everywhere if it is lost."""
        before = -1
        while self._reached > before:
            before = self._reached
            last = int(np.searchsorted(self._along, self._along[before] + SEARCH_AHEAD, side="right"))
            self._reached, distance = self._nearest(pose, before, last)
        if distance > LOST:
            self._reached, _ = self._nearest(pose, 0, len(self._points))

    def to_go(self, pose: Pose2D) -> float:
        """Return the way to the end: straight to where it was located, then along the plan [m]."""
        here = self._points[self._reached]
        along = float(self._along[-1] - self._along[self._reached])
        return max(pose.distance_to(self.end), along - math.hypot(here[0] - pose.x, here[1] - pose.y))

    def point_ahead(self, distance: float) -> tuple[float, float]:
        """Return the point of the plan that lies ``distance`` [m] on, or its end."""
        s = self._along[self._reached] + distance
        x, y = (float(np.interp(s, self._along, self._points[:, axis])) for axis in (0, 1))
        return x, y

    def ahead(self, distance: float, costmap: Costmap) -> tuple[Floats, Floats]:
        """Return the plan from where the robot is to ``distance`` [m] on, or to the edge of the costmap.

        Returns
        -------
        points : (m, 2) array
            x, y [m], evenly spaced.
        remaining : (m,) array
            Way from each to the last [m].
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
