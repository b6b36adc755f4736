"""Scans of the last metres: one scan fits many places of a map, several together fit few."""

import math
from collections import deque
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle

SPACING, SPACING_TURN = 0.4, 0.6
"""Distance or turn from the scan before at which a scan is kept [m, rad]."""

SCANS = 12
"""Number of scans kept; odometry has drifted too far since older ones."""


class ScanHistory:
    """The last scans with the odometry of each."""

    def __init__(self) -> None:
        self._scans: deque[tuple[Pose2D, NDArray[np.float64]]] = deque(maxlen=SCANS)

    def note(self, odom: Pose2D, points: NDArray[np.float64]) -> bool:
        """Keep a scan if the robot has moved since the last one; return whether it was kept.

        Parameters
        ----------
        odom : Pose2D
            Pose of the robot in the odometry frame.
        points : (n, 2) array
            End points of beams in the robot's frame [m].
        """
        if self._scans:
            last = self._scans[-1][0]
            if last.distance_to(odom) < SPACING and abs(wrap_angle(odom.theta - last.theta)) < SPACING_TURN:
                return False
        self._scans.append((odom, points))
        return True

    def seen(self) -> NDArray[np.float64]:
        """Return the beams of all scans, in the robot's frame at the newest scan.

        Returns
        -------
        (m, 4) array
            x, y of the end of a beam, and x, y of the robot that measured it [m].
        """
        here = self._scans[-1][0].inverse()
        return np.concatenate([_rays(points, here @ odom) for odom, points in self._scans])

    @property
    def metres(self) -> float:
        """Distance driven from the oldest scan to the newest [m]."""
        poses = [odom for odom, _ in self._scans]
        return sum((before.distance_to(after) for before, after in pairwise(poses)), 0.0)

    @property
    def full(self) -> bool:
        """Whether each new scan replaces an older one."""
        return len(self._scans) == SCANS

    def rebase(self, jump: Pose2D) -> None:
        """Continue after a reset of the odometry; ``jump`` is the pose of the new odometry frame in the old one."""
        back = jump.inverse()
        self._scans = deque(((back @ odom, points) for odom, points in self._scans), SCANS)

    def forget(self) -> None:
        """Remove all scans."""
        self._scans.clear()


def _rays(points: NDArray[np.float64], pose: Pose2D) -> NDArray[np.float64]:
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    rays = np.empty((len(points), 4))
    rays[:, 2:] = pose.x, pose.y
    rays[:, :2] = points @ np.array(((c, s), (-s, c))) + rays[:, 2:]
    return rays
