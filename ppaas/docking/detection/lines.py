"""Clusters, corners and straight lines in the readings of a scan."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle

Points = NDArray[np.float64]


class StraightLine(NamedTuple):
    """Straight line through readings: middle, direction [rad] and length [m], and the errors' root mean square [m]."""

    middle: tuple[float, float]
    direction: float
    length: float
    error: float


def clusters(points: Points, gap: float) -> list[Points]:
    """Return the readings as clusters in the order of the beams; a new one begins where they are apart by ``gap`` [m].

    The first and the last cluster of a whole turn are one if they meet.
    """
    if not len(points):
        return []
    apart = np.hypot(*np.diff(points, axis=0).T) > gap
    found = np.split(points, np.flatnonzero(apart) + 1)
    if len(found) > 1 and math.dist(points[0], points[-1]) <= gap:
        found = [np.concatenate((found[-1], found[0])), *found[1:-1]]
    return found


def pieces(cluster: Points, tolerance: float) -> list[Points]:
    """Return a cluster split at its corners, in order: readings are within a tolerance [m] of the line of the ends."""
    found, open_ = [], [cluster]
    while open_:
        piece = open_.pop()
        corner = corner_of(piece, tolerance)
        if corner is None:
            found.append(piece)
        else:
            open_ += [piece[corner:], piece[: corner + 1]]
    return found


def corner_of(piece: Points, tolerance: float) -> int | None:
    """Return the index of the reading that is farthest from the line between the ends, None if it is near."""
    if len(piece) < 3:
        return None
    x, y = piece[-1] - piece[0]
    length = math.hypot(x, y)
    if length < 1e-9:
        return None
    off = np.abs(x * (piece[:, 1] - piece[0, 1]) - y * (piece[:, 0] - piece[0, 0])) / length
    farthest = int(off.argmax())
    inside = 0 < farthest < len(piece) - 1
    return farthest if inside and off[farthest] > tolerance else None


def line_through(points: Points) -> StraightLine:
    """Return the line with the least squared distances from at least two readings."""
    mean = points.mean(axis=0)
    x, y = (points - mean).T
    direction = 0.5 * math.atan2(2.0 * float((x * y).sum()), float((x * x - y * y).sum()))
    c, s = math.cos(direction), math.sin(direction)
    along, across = c * x + s * y, c * y - s * x
    begin, end = float(along.min()), float(along.max())
    middle = mean + 0.5 * (begin + end) * np.array((c, s))
    return StraightLine(
        (float(middle[0]), float(middle[1])), direction, end - begin, float(np.sqrt((across**2).mean()))
    )


def face_on(line: StraightLine, expected: Pose2D) -> Pose2D:
    """Return the face of a dock on a line: its x is across the line, on the side that is expected."""
    normal = line.direction + 0.5 * math.pi
    if abs(wrap_angle(normal - expected.theta)) > 0.5 * math.pi:
        normal += math.pi
    return Pose2D(*line.middle, wrap_angle(normal))


def near(points: Points, expected: Pose2D, reach: float) -> NDArray[np.bool_]:
    """Return a mask of the readings within a distance [m] of a place."""
    mask: NDArray[np.bool_] = np.hypot(points[:, 0] - expected.x, points[:, 1] - expected.y) <= reach
    return mask
