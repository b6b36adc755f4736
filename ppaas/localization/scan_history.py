"""What the laser has seen on the last metres: where one scan fits many places, several fit few."""

import math
from collections import deque
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle

SPACING, SPACING_TURN = 0.4, 0.6
"""A scan is kept where the robot was so far from, or so turned against, the one before [m, rad]."""

SCANS = 12
"""Most scans that are kept: odometry has drifted since the older ones."""


class History:
    """Scans and where odometry was."""

    def __init__(self) -> None:
        self._scans: deque[tuple[Pose2D, NDArray[np.float64]]] = deque(maxlen=SCANS)

    def note(self, odom: Pose2D, points: NDArray[np.float64]) -> bool:
        """Keep a scan, unless the robot has not moved; tell whether it was kept.

        Parameters
        ----------
        odom : Pose2D
            Of the robot in the odometry frame.
        points : (n, 2) array
            Where beams ended, in the robot's frame [m].
        """
        if self._scans:
            last = self._scans[-1][0]
            if last.distance_to(odom) < SPACING and abs(wrap_angle(odom.theta - last.theta)) < SPACING_TURN:
                return False
        self._scans.append((odom, points))
        return True

    def seen(self) -> NDArray[np.float64]:
        """Return all that was seen, in the robot's frame when the newest scan was kept.

        Returns
        -------
        (m, 4) array
            x, y where a beam ended, and where the robot was that saw it [m].
        """
        here = self._scans[-1][0].inverse()
        return np.concatenate([_rays(points, here @ odom) for odom, points in self._scans])

    @property
    def metres(self) -> float:
        """How far the robot drove from the oldest scan to the newest."""
        poses = [odom for odom, _ in self._scans]
        return sum((before.distance_to(after) for before, after in pairwise(poses)), 0.0)

    @property
    def full(self) -> bool:
        """Tell whether each scan takes the place of an older one."""
        return len(self._scans) == SCANS

    def rebase(self, jump: Pose2D) -> None:
        """Take note that odometry began anew; ``jump`` is the pose of its new frame in the one before."""
        back = jump.inverse()
        self._scans = deque(((back @ odom, points) for odom, points in self._scans), SCANS)

    def forget(self) -> None:
        """Begin anew."""
        self._scans.clear()


def _rays(points: NDArray[np.float64], pose: Pose2D) -> NDArray[np.float64]:
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    rays = np.empty((len(points), 4))
    rays[:, 2:] = pose.x, pose.y
    rays[:, :2] = points @ np.array(((c, s), (-s, c))) + rays[:, 2:]
    return rays
