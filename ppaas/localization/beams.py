"""Selection of the beams of a ``sensor_msgs/LaserScan`` that localization compares with the map."""

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.sensor_msgs import LaserScan

Row = TypeVar("Row", np.float64, np.int64)

MAX_RANGES = 100_000
"""Largest number of ranges in a scan; real lasers have a few thousand."""

MOST_TURNED = 2.2 * math.pi
"""Largest angle that the beams of a scan cover [rad]: some drivers turn a little more than once."""

SPACING = 0.1
"""Edge of the cells of which each contributes at most one point [m]."""


def check_scan(scan: LaserScan) -> None:
    """Check the angles and limits of a scan.

    As in amcl, ``angle_min``, ``angle_increment`` and the number of ranges count, while ``angle_max`` may be a little
    off (see `excess_of`).

    Raises
    ------
    InvalidInput
        There is no range, or less than half or more than twice as many as the angles say; an angle or limit is not
        finite; or the beams go round more than once, as with degrees.
    """
    _check_angles(scan)
    count = len(scan.ranges)
    if not count:
        raise InvalidInput("a scan has no ranges: send one per beam, null where there is no reading")
    turned = abs(scan.angle_increment) * (count - 1)
    if turned > MOST_TURNED or (scan.angle_increment == 0.0 and count > 1):
        raise InvalidInput(
            f"{count} ranges in steps of angle_increment {scan.angle_increment:g} cover {turned:.2f} rad: a scan "
            "covers more than 0 rad and at most one turn, in radians"
        )
    expected = count - excess_of(scan)
    if not 0.5 * expected <= count <= max(2.0 * expected, 2.0):
        raise InvalidInput(
            f"a scan from angle_min {scan.angle_min:g} to angle_max {scan.angle_max:g} in steps of "
            f"{scan.angle_increment:g} rad must have {expected:.0f} ranges, not {count}"
        )


def excess_of(scan: LaserScan) -> float:
    """Return the number of ranges beyond the number that the angles give; one more or less is usual and counts as 0."""
    if not math.isfinite(scan.angle_max) or scan.angle_increment == 0.0:
        return 0.0
    excess = len(scan.ranges) - 1.0 - (scan.angle_max - scan.angle_min) / scan.angle_increment
    return excess if abs(excess) > 1.5 else 0.0


def _check_angles(scan: LaserScan) -> None:
    limits = (scan.angle_min, scan.angle_increment, scan.range_min, scan.range_max)
    if not all(map(math.isfinite, limits)) or scan.range_max <= 0.0:
        raise InvalidInput("angle_min, angle_increment, range_min and range_max of a scan must be finite numbers")
    if len(scan.ranges) > MAX_RANGES:
        raise InvalidInput(f"a scan has at most {MAX_RANGES} ranges, not {len(scan.ranges)}")


def scan_points(scan: LaserScan, laser: Pose2D) -> NDArray[np.float64]:
    """Return the end points of all beams with a reading.

    Parameters
    ----------
    scan : LaserScan
        Null, NaN, infinity, 0 and values outside (range_min, range_max) are not readings.
    laser : Pose2D
        Pose of the sensor in the frame of the points returned.

    Returns
    -------
    (m, 2) array
        x, y [m].

    Raises
    ------
    InvalidInput
        The angles or limits are not finite, or there are too many ranges.
    """
    _check_angles(scan)
    ranges = np.array(scan.ranges, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        hits = np.flatnonzero((ranges > max(scan.range_min, 0.0)) & (ranges < scan.range_max))
    angles = scan.angle_min + hits * scan.angle_increment + laser.theta
    points = np.empty((len(hits), 2))
    points[:, 0] = laser.x + ranges[hits] * np.cos(angles)
    points[:, 1] = laser.y + ranges[hits] * np.sin(angles)
    return points


def choose_beams(points: NDArray[np.float64], max_beams: int) -> NDArray[np.float64]:
    """Return at most ``max_beams`` points of a scan, spread evenly over the surfaces seen instead of over the angles.

    An unmapped box close in front of the robot takes up half of the beams, and would pull the pose until the box
    matches some wall. With one point per cell of edge ``SPACING``, it counts in proportion to its length only.

    Parameters
    ----------
    points : (n, 2) or (n, 4) array
        x, y [m], in the order of the beams; further columns are returned unchanged.
    max_beams : int
        Largest number of points to return.
    """
    return spread(thinned(points), max_beams)


def thinned(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return one of the (n, 2) or (n, 4) points per cell of edge ``SPACING``, in the order of the beams."""
    cells = np.floor(points / SPACING).astype(np.int64)
    _, first = np.unique(cells[:, 0] * (1 << 32) + cells[:, 1], return_index=True)
    kept: NDArray[np.float64] = points[np.sort(first)]
    return kept


def choose_rays(scan: LaserScan, laser: Pose2D, max_beams: int) -> NDArray[np.float64]:
    """Return at most ``max_beams`` beams of a scan, spread evenly over its angles, including beams without a hit.

    Parameters
    ----------
    scan : LaserScan
        Null, infinity and values from range_max up mean no hit; NaN and values up to range_min are not readings.
    laser : Pose2D
        Pose of the sensor in the robot's frame.
    max_beams : int
        Largest number of beams to return.

    Returns
    -------
    (m, 4) array
        x, y of the laser [m], direction of the beam [rad], both in the robot's frame, and range, at most
        ``range_max`` [m].

    Raises
    ------
    InvalidInput
        See `scan_points`.
    """
    _check_angles(scan)
    ranges = np.array([math.inf if value is None else value for value in scan.ranges], dtype=np.float64)
    chosen = spread(np.flatnonzero(ranges > max(scan.range_min, 0.0)), max_beams)
    rays = np.empty((len(chosen), 4))
    rays[:, 0], rays[:, 1] = laser.x, laser.y
    rays[:, 2] = scan.angle_min + chosen * scan.angle_increment + laser.theta
    rays[:, 3] = np.minimum(ranges[chosen], scan.range_max)
    return rays


def spread(rows: NDArray[Row], most: int) -> NDArray[Row]:
    """Return at most ``most`` rows of an array, spread evenly."""
    if len(rows) <= most:
        return rows
    chosen: NDArray[Row] = rows[np.linspace(0, len(rows) - 1, most).round().astype(np.int64)]
    return chosen
