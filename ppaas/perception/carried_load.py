"""Scans without what the robot carries: its legs are no obstacles, and hide what is behind them."""

import math

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.footprints import Footprint
from ppaas.geometry import convex_outline, reach_of, within_hull
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.transforms.spatial import Rigid, matrix_of

MARGIN = 0.05
"""Distance beyond the outline of a load up to which a reading shows the load [m]."""


class LoadFilter:
    """Removes the readings of a load from scans.

    Parameters
    ----------
    outline : Footprint
        Outline of the load in the robot's frame; at least three corners.
    """

    def __init__(self, outline: Footprint) -> None:
        self._hull = convex_outline(outline)
        self._reach = reach_of(self._hull) + MARGIN

    def without_load(self, scan: LaserScan, mount: Rigid) -> LaserScan:
        """Return a scan in which beams that end in the load, or just beside it, have no reading.

        Parameters
        ----------
        scan : LaserScan
        mount : Rigid
            Pose of the laser in the robot's frame.
        """
        ranges = np.array(scan.ranges, dtype=np.float64)
        near = np.flatnonzero(ranges <= self._reach + math.hypot(mount.x, mount.y, mount.z))
        if not len(near):
            return scan
        angles = float(scan.angle_min) + near.astype(np.float64) * float(scan.angle_increment)
        hidden = near[self._are_inside(angles, ranges[near], mount)]
        ranges[hidden] = np.nan
        return msgspec.structs.replace(scan, ranges=ranges.tolist()) if len(hidden) else scan

    def _are_inside(self, angles: NDArray[np.float64], ranges: NDArray[np.float64], mount: Rigid) -> NDArray[np.bool_]:
        matrix = matrix_of(mount)
        ends = np.stack((ranges * np.cos(angles), ranges * np.sin(angles)), axis=1) @ matrix[:2, :2].T + matrix[:2, 3]
        return within_hull(self._hull, ends[:, 0], ends[:, 1], MARGIN)
