"""Scans of lasers that hang upside down or are tilted, as a level laser at the same place would send them.

A scan is mirrored for a laser that is upside down, as amcl does (``amcl_node.cpp``). Beams of a tilted laser are
projected onto the plane in which the robot drives, as laser_geometry and costmap_2d do; those that end on the floor or
high above the robot are not readings.
"""

import math
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.transforms.planar import LARGEST_TILT, MAX_TILT
from ppaas.transforms.spatial import Rigid

FLOOR = 0.05
"""Height up to which a beam has hit the floor [m]."""

CEILING = 2.0
"""Height from which on a beam has passed above the robot, as ``max_obstacle_height`` of costmap_2d [m]."""


class LevelScan(NamedTuple):
    """Scan of a level laser, and its pose in the robot's frame."""

    scan: LaserScan
    laser: Pose2D


class _Axes(NamedTuple):
    """Axes x and y of a laser in the robot's frame, and the height of its z axis, −1 to 1."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    up: float


def level_scan(scan: LaserScan, mount: Rigid, ground: float = 0.0) -> LevelScan:
    """Return a scan as a level laser at the same place would send it.

    Parameters
    ----------
    scan : LaserScan
        Returned unchanged if its laser is level.
    mount : Rigid
        Pose of the laser in the robot's frame.
    ground : float
        Height of the floor in the robot's frame [m].

    Raises
    ------
    InvalidInput
        The laser is tilted by more than ``LARGEST_TILT``.
    """
    axes, tilt = _axes(mount), mount.tilt
    if tilt > LARGEST_TILT:
        raise InvalidInput(
            f"laser {scan.header.frame_id!r} is tilted by {math.degrees(tilt):.0f}°, so its beams leave the plane in "
            f"which the robot drives: mount it level, or send the scans of a laser that is tilted by at most "
            f"{math.degrees(LARGEST_TILT):.0f}°"
        )
    laser = Pose2D(mount.x, mount.y, math.atan2(axes.x[1], axes.x[0]))
    if axes.up < 0.0:
        scan = msgspec.structs.replace(
            scan, angle_min=-scan.angle_min, angle_max=-scan.angle_max, angle_increment=-scan.angle_increment
        )
        axes = _Axes(axes.x, -axes.y, -axes.up)
    return LevelScan(scan if tilt <= MAX_TILT else _projected(scan, axes, laser.theta, mount.z - ground), laser)


def _projected(scan: LaserScan, axes: _Axes, heading: float, height: float) -> LaserScan:
    """Return a scan whose beams are projected to the ground, at the angles of the original one.

    Beams without an echo are not readings either: it is not known what they passed above.
    """
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    ranges = np.array(scan.ranges, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        ranges[~((ranges > scan.range_min) & (ranges < scan.range_max))] = np.nan
        along = np.cos(angles)[:, None] * axes.x + np.sin(angles)[:, None] * axes.y
        ends = height + ranges * along[:, 2]
        ranges[~((ends > FLOOR) & (ends < CEILING))] = np.nan
    seen = np.flatnonzero(~np.isnan(ranges))
    bearings = np.arctan2(along[seen, 1], along[seen, 0]) - heading - angles[seen]
    off = (bearings + math.pi) % (2.0 * math.pi) - math.pi
    beams = np.clip(seen + np.rint(off / (scan.angle_increment or 1.0)).astype(np.int64), 0, len(ranges) - 1)
    flat = np.full(len(ranges), np.inf)
    np.minimum.at(flat, beams, ranges[seen] * np.hypot(along[seen, 0], along[seen, 1]))
    flat[np.isinf(flat)] = np.nan
    return msgspec.structs.replace(scan, ranges=flat.tolist())


def _axes(mount: Rigid) -> _Axes:
    """Return the first two columns of a rotation matrix, and the height of the third."""
    x, y, z, w = mount[3:]
    return _Axes(
        np.array((1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y))),
        np.array((2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x))),
        1.0 - 2.0 * (x * x + y * y),
    )
