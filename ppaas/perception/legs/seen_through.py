"""Memory of the last scans, which shows what has moved: an object where an earlier beam passed has come there.

Source: "free-space violations", as in Leigh et al., "Person tracking and following with 2D laser scanners" (ICRA
2015), where a local occupancy grid holds the free space.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D
from ppaas.perception.legs.segments import is_circle, spacing_of

PERIOD = 0.3
"""Least time between two scans that are kept [s]."""

LENGTH = 5
"""Number of scans that are kept."""

BEYOND = 0.25
"""Distance behind a point beyond which a beam must have ended [m]."""

HALF_WIDTH = 0.08
"""Half of the width around a point in which all beams must have passed [m]."""


class SeenThrough:
    """Last scans of one laser, with the poses of the laser in the frame of the odometry."""

    def __init__(self) -> None:
        self._scans: deque[tuple[float, LaserReading]] = deque(maxlen=LENGTH)

    def add(self, reading: LaserReading, stamp: float) -> None:
        """Add a scan in the frame of the odometry, at its time [s], unless one of a moment before is kept.

        If the clock was set back, the scans before are forgotten.
        """
        if self._scans and stamp < self._scans[-1][0]:
            self._scans.clear()
        if not self._scans or stamp - self._scans[-1][0] >= PERIOD:
            self._scans.append((stamp, reading))

    def share(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of the kept scans that saw through each point, from 0 to 1.

        Parameters
        ----------
        points : (n, 2) array
            x, y in the frame of the odometry [m].

        Returns
        -------
        (n,) array
        """
        if not self._scans or not len(points):
            return np.zeros(len(points))
        passed = np.stack([_passed(reading, points) for _, reading in self._scans])
        share: NDArray[np.float64] = passed.mean(axis=0)
        return share


def _passed(reading: LaserReading, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether all beams of a scan towards each point ended behind it, or hit nothing."""
    origin: Pose2D = reading.origin
    x, y = points[:, 0] - origin.x, points[:, 1] - origin.y
    away, step = np.hypot(x, y), spacing_of(reading)
    if step <= 0.0:
        return np.zeros(len(points), bool)
    sign = 1.0 if reading.angles[-1] >= reading.angles[0] else -1.0
    bearing = np.mod(sign * (np.arctan2(y, x) - origin.theta - reading.angles[0]), 2.0 * np.pi)
    middle = np.rint(bearing / step).astype(np.int64)
    half = np.ceil(HALF_WIDTH / np.maximum(away, HALF_WIDTH) / step).astype(np.int64)
    widest = int(half.max())
    offsets = np.arange(-widest, widest + 1)
    beams = middle[:, None] + offsets
    count = len(reading.ranges)
    known = np.ones_like(beams, bool) if is_circle(reading) else (beams >= 0) & (beams < count)
    ranges = reading.ranges[beams % count]
    # NaN compares as false: a beam without a reading has seen nothing.
    with np.errstate(invalid="ignore"):
        beyond = known & (ranges > (away + BEYOND)[:, None])
    passed: NDArray[np.bool_] = (beyond | (np.abs(offsets) > half[:, None])).all(axis=1)
    return passed
