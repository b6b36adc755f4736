"""Plan that a robot follows, and the robot's progress along it."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.kernels.followed_path import locate, point_at, points_ahead
from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, Poses, yaw_of

Floats = NDArray[np.float64]


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
        self._reached = locate(self._points, self._along, self._reached, float(pose.x), float(pose.y))

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
        x, y = point_at(self._points, self._along, self._along[self._reached] + distance)
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
        info = costmap.info
        x, y, theta = map(float, info.origin)
        points, remaining = points_ahead(
            self._points, self._along, self._reached, float(distance), (x, y, theta), float(info.resolution), info.shape
        )
        return points, remaining
