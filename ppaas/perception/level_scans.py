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
from ppaas.geometry import Pose2D, yaw_of
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
    tilt, upside_down = mount.tilt, mount.qx * mount.qx + mount.qy * mount.qy > 0.5
    if tilt > LARGEST_TILT:
        raise InvalidInput(
            f"laser {scan.header.frame_id!r} is tilted by {math.degrees(tilt):.0f}°, so its beams leave the plane in "
            f"which the robot drives: mount it level, or send the scans of a laser that is tilted by at most "
            f"{math.degrees(LARGEST_TILT):.0f}°"
        )
    laser = Pose2D(mount.x, mount.y, yaw_of(mount.qx, mount.qy, mount.qz, mount.qw))
    if upside_down:
        scan = msgspec.structs.replace(
            scan, angle_min=-scan.angle_min, angle_max=-scan.angle_max, angle_increment=-scan.angle_increment
        )
    if tilt <= MAX_TILT:
        return LevelScan(scan, laser)
    turn = mount._replace(x=0.0, y=0.0, z=0.0)
    x_axis, y_axis = (np.array((turn @ axis)[:3]) for axis in (Rigid(1.0), Rigid(0.0, 1.0)))
    beams = _Beams(x_axis, -y_axis if upside_down else y_axis, laser.theta, mount.z - ground)
    return LevelScan(_projected(scan, beams), laser)


class _Beams(NamedTuple):
    """Axes x and y of a laser in the robot's frame, the heading of x [rad], and its height above the floor [m]."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    heading: float
    height: float


def _projected(scan: LaserScan, beams: _Beams) -> LaserScan:
    """Return a scan whose beams are projected to the ground, at the angles of the original one.

    Beams without an echo are not readings either: it is not known what they passed above.
    """
    angles = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    ranges = np.array(scan.ranges, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        ranges[~((ranges > max(scan.range_min, 0.0)) & (ranges < scan.range_max))] = np.nan
        along = np.cos(angles)[:, None] * beams.x + np.sin(angles)[:, None] * beams.y
        ends = beams.height + ranges * along[:, 2]
        ranges[~((ends > FLOOR) & (ends < CEILING))] = np.nan
    seen = np.flatnonzero(~np.isnan(ranges))
    bearings = np.arctan2(along[seen, 1], along[seen, 0]) - beams.heading - angles[seen]
    off = (bearings + math.pi) % (2.0 * math.pi) - math.pi
    nearest = np.clip(seen + np.rint(off / (scan.angle_increment or 1.0)).astype(np.int64), 0, len(ranges) - 1)
    flat = np.full(len(ranges), np.inf)
    np.minimum.at(flat, nearest, ranges[seen] * np.hypot(along[seen, 0], along[seen, 1]))
    flat[np.isinf(flat)] = np.nan
    return msgspec.structs.replace(scan, ranges=flat.tolist())
