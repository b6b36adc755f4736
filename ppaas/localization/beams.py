"""From ``sensor_msgs/LaserScan`` to the end points that localization reads."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import LaserScan

MAX_RANGES = 100_000
"""Most ranges a scan may have; a real laser has some thousand."""

SPACING = 0.1
"""Edge of the cells in each of which one point counts [m]."""


def scan_points(scan: LaserScan, laser: Pose2D) -> NDArray[np.float64]:
    """Return the end points of the beams that hit something.

    Parameters
    ----------
    scan : LaserScan
        Null, NaN, infinity and what lies outside (range_min, range_max) is no reading.
    laser : Pose2D
        Of the sensor in the frame that the points are wanted in.

    Returns
    -------
    (m, 2) array
        x, y [m].

    Raises
    ------
    InvalidInput
        The angles or limits are not finite, or there are too many ranges.
    """
    limits = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
    if not all(map(math.isfinite, limits)) or scan.range_max <= 0.0:
        raise InvalidInput("angle_min, angle_increment, range_min and range_max of a scan must be finite numbers")
    if len(scan.ranges) > MAX_RANGES:
        raise InvalidInput(f"a scan has at most {MAX_RANGES} ranges, not {len(scan.ranges)}")
    ranges = np.array(scan.ranges, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        hits = np.flatnonzero((ranges > scan.range_min) & (ranges < scan.range_max))
    angles = scan.angle_min + hits * scan.angle_increment + laser.theta
    points = np.empty((len(hits), 2))
    points[:, 0] = laser.x + ranges[hits] * np.cos(angles)
    points[:, 1] = laser.y + ranges[hits] * np.sin(angles)
    return points


def choose_beams(points: NDArray[np.float64], max_beams: int) -> NDArray[np.float64]:
    """Return at most so many of a scan's points, spread over what it sees and not over its angles.

    A box that is not in the map, close in front of the robot, takes up half of the beams, and would drag the pose until
    it fits some wall. One point in each cell of ``SPACING`` gives it no more weight than its length.

    Parameters
    ----------
    points : (n, 2) array
        x, y [m], in the order of the beams.
    max_beams : int
        Most points to return.
    """
    cells = np.floor(points / SPACING).astype(np.int64)
    _, first = np.unique(cells[:, 0] * (1 << 32) + cells[:, 1], return_index=True)
    chosen = np.sort(first)
    if len(chosen) > max_beams:
        chosen = chosen[np.linspace(0, len(chosen) - 1, max_beams).round().astype(np.int64)]
    beams: NDArray[np.float64] = points[chosen]
    return beams
