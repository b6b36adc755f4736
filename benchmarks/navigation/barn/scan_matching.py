"""Scans of the BARN bench: smoothed over beams of one surface, and aligned with earlier ones against drift.

With odometry alone, obstacles that were seen before a detour and after it are shifted against each other, and together
they close open gaps. The alignment is point-to-line (Chen and Medioni, "Object modelling by registration of multiple
range images", 1992): each line runs through a point that was seen before and its neighbours.

Each beam marks the cell of its endpoint. Of many noisy beams on a near surface, some always end too close, so without
smoothing a gap appears narrower by a few standard deviations of the laser on both sides.
"""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.geometry import Pose2D, wrap_angle

Floats = NDArray[np.float64]

FAR = 5.0
"""Maximum range of points that are matched [m]."""
REACH = 0.15
"""Maximum distance between corresponding points [m]."""
SIGMA = 0.03
"""Standard deviation of a point from the line of its correspondence [m]: noise and the curvature of surfaces."""
ODOMETRY_SIGMA = (0.01, 0.01, 0.01)
"""Standard deviations of odometry from one cycle to the next [m, m, rad]."""
POINTS = 150
"""Maximum number of points of a scan that are matched."""
ITERATIONS = 3
"""Number of iterations, each with new correspondences."""
SPACING, SPACING_TURN = 0.3, 0.4
"""Motion since the last stored scan after which a scan is stored [m, rad]."""
APART = 0.04
"""Approximate smallest distance between stored points [m]."""
MIN_COSINE = 0.5
"""Cosine of the largest angle between the normals of corresponding points."""
BESIDE = 0.1
"""Maximum distance between points of neighbouring beams on one surface [m]."""


class ScanMatching:
    """Corrects odometry by laser scans; the frame is the odometry frame at the start."""

    def __init__(self) -> None:
        self._drift = Pose2D(0.0, 0.0, 0.0)
        self._seen: Floats = np.empty((0, 4))
        self._cells: set[tuple[int, int]] = set()
        self._last: Pose2D | None = None

    def correct(self, odom: Pose2D, reading: LaserReading) -> Pose2D:
        """Return the corrected pose of the robot.

        Parameters
        ----------
        odom : Pose2D
            Pose by odometry.
        reading : LaserReading
            Scan at that pose, with beams in angular order.
        """
        surfaces = _surfaces(reading)
        pose = self._drift @ odom
        near = self._seen[np.hypot(self._seen[:, 0] - pose.x, self._seen[:, 1] - pose.y) <= FAR]
        if len(near) and len(surfaces):
            chosen = np.linspace(0, len(surfaces) - 1, min(POINTS, len(surfaces))).round().astype(np.int64)
            pose = _aligned(surfaces[chosen], pose, near)
            self._drift = pose @ odom.inverse()
        if self._is_new(pose):
            self._remember(_transformed(surfaces, pose))
            self._last = pose
        return pose

    def _is_new(self, pose: Pose2D) -> bool:
        last = self._last
        return last is None or (
            last.distance_to(pose) >= SPACING or abs(wrap_angle(pose.theta - last.theta)) >= SPACING_TURN
        )

    def _remember(self, surfaces: Floats) -> None:
        fresh = []
        for row, cell in zip(surfaces, map(tuple, np.floor(surfaces[:, :2] / APART).astype(int).tolist()), strict=True):
            if cell not in self._cells:
                self._cells.add(cell)
                fresh.append(row)
        self._seen = np.concatenate((self._seen, np.array(fresh).reshape(-1, 4)))


def _surfaces(reading: LaserReading) -> Floats:
    """Return (n, 4) endpoints x, y of the beams [m] and unit normals of the surface, in the robot's frame."""
    ranges = np.where((reading.ranges > 0.0) & (reading.ranges <= FAR), reading.ranges, np.nan)
    points = ranges[:, None] * np.column_stack((np.cos(reading.angles), np.sin(reading.angles)))
    along = points[2:] - points[:-2]
    length = np.hypot(along[:, 0], along[:, 1])
    steps = np.hypot(*np.diff(points, axis=0).T)
    with np.errstate(invalid="ignore"):
        fine = (steps[1:] < BESIDE) & (steps[:-1] < BESIDE) & (length > 1e-6)
    along = along[fine] / length[fine, None]
    return np.column_stack((points[1:-1][fine], -along[:, 1], along[:, 0]))


def _transformed(surfaces: Floats, pose: Pose2D) -> Floats:
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    turn = np.array(((c, s), (-s, c)))
    return np.hstack((surfaces[:, :2] @ turn + (pose.x, pose.y), surfaces[:, 2:] @ turn))


def _aligned(surfaces: Floats, predicted: Pose2D, seen: Floats) -> Pose2D:
    """Return the pose that aligns surfaces with stored ones: Gauss-Newton steps with odometry as prior.

    Parameters
    ----------
    surfaces : (n, 4) array
        Points and normals of the scan in the robot's frame.
    predicted : Pose2D
        Prediction by odometry.
    seen : (m, 4) array
        Stored points and normals near the robot.
    """
    pose, precision = predicted, 1.0 / np.square(ODOMETRY_SIGMA)
    points = KDTree(seen[:, :2])
    for _ in range(ITERATIONS):
        now = _transformed(surfaces, pose)
        distance, index = points.query(now[:, :2])
        # A point with the opposite normal belongs to the other side of an obstacle.
        fits = (distance <= REACH) & ((seen[index, 2:] * now[:, 2:]).sum(axis=1) > MIN_COSINE)
        there = seen[index[fits]]
        off, normals = now[fits, :2] - there[:, :2], there[:, 2:]
        arm = now[fits, :2] - (pose.x, pose.y)
        rows = np.column_stack((normals, arm[:, 0] * normals[:, 1] - arm[:, 1] * normals[:, 0]))
        error = (normals * off).sum(axis=1)
        # Cauchy weights reduce the influence of outliers.
        weighed = rows / (SIGMA * SIGMA + np.square(error))[:, None]
        moved = np.array((pose.x - predicted.x, pose.y - predicted.y, wrap_angle(pose.theta - predicted.theta)))
        step = np.linalg.solve(weighed.T @ rows + np.diag(precision), -weighed.T @ error - precision * moved)
        pose = Pose2D(pose.x + float(step[0]), pose.y + float(step[1]), wrap_angle(pose.theta + float(step[2])))
    return pose


# -- scan smoothing ----------------------------------------------------------------------------------------------------

ARC = 0.04
"""Maximum lateral distance between the endpoints of averaged beams [m]."""
DEPTH = 0.08
"""Maximum difference between the ranges of averaged beams [m]."""
MOST = 12
"""Maximum number of averaged beams on each side."""


def smoothed(reading: LaserReading) -> LaserReading:
    """Return a reading in which each range is the mean of neighbouring ranges on the same surface.

    Parameters
    ----------
    reading : LaserReading
        Reading whose beams are in angular order and evenly spaced.

    Returns
    -------
    LaserReading
        Invalid ranges and those without a hit are unchanged, and are not part of any mean.
    """
    ranges = reading.ranges
    hit = np.isfinite(ranges) & (ranges > 0.0)
    if np.count_nonzero(hit) < 2:
        return reading
    spacing = abs(float(reading.angles[1] - reading.angles[0]))
    known = np.where(hit, ranges, np.nan)
    # Number of beams within the arc, at the range of each beam.
    reach = np.zeros(len(ranges), np.int64)
    reach[hit] = np.minimum(ARC / np.maximum(ranges[hit] * spacing, ARC / MOST), MOST)
    total, count = known.copy(), np.ones(len(ranges))
    for offset in range(1, min(int(reach.max()), len(ranges) - 1) + 1):
        low, high = slice(None, -offset), slice(offset, None)
        same = np.abs(known[high] - known[low]) <= DEPTH
        for here, there in ((low, high), (high, low)):
            counts = same & (reach[here] >= offset)
            total[here] += np.where(counts, known[there], 0.0)
            count[here] += counts
    return LaserReading(reading.origin, reading.angles, np.where(hit, total / count, ranges))
