"""What of a scan stands out from the map: things of a person's size that the map knows nothing of."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.costmap.obstacle_memory import WALL_MARGIN

REACH = 6.0
"""Beams that go farther say too little: what they hit is hit by few [m]."""
APART = 0.2
"""What is hit by beams beside one another is one thing, unless it is so much farther apart than they are [m]."""
LEAST = 3
"""Beams that must hit a thing."""
LARGEST = 1.0
"""Nothing that is longer is taken for somebody [m]."""
SMALLEST_RADIUS = 0.1


class UnmappedObject(NamedTuple):
    """Where something round is taken to be, in the frame of the map [m]."""

    x: float
    y: float
    radius: float


def unmapped_objects_in(reading: LaserReading, layers: MapLayers) -> list[UnmappedObject]:
    """Return what stands out.

    Parameters
    ----------
    reading : LaserReading
        Taken in the frame of the map.
    layers : MapLayers
    """
    hit, points = _unknown_to_map(reading, layers)
    if not len(hit):
        return []
    near = np.hypot(*np.diff(points, axis=0).T) < APART + 2.0 * _spacing(reading) * reading.ranges[hit[1:]]
    parts = np.split(np.arange(len(hit)), np.flatnonzero(~near) + 1)
    if len(parts) > 1 and np.hypot(*(points[0] - points[-1])) < APART:
        parts = [np.concatenate((parts[-1], parts[0])), *parts[1:-1]]  # round the back of a laser that sees all around
    found = (_thing(points[part], reading) for part in parts if len(part) >= LEAST)
    return [thing for thing in found if thing is not None]


def _unknown_to_map(reading: LaserReading, layers: MapLayers) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return which beams hit what is not in the map, and where, (n, 2) x, y [m]."""
    hit = np.flatnonzero(reading.ranges < REACH)
    heading = reading.angles[hit] + reading.origin.theta
    points = np.array(reading.origin[:2]) + reading.ranges[hit, None] * np.stack(
        (np.cos(heading), np.sin(heading)), axis=1
    )
    cells = layers.grid.info.to_cells(points)
    inside = ((cells >= 0) & (cells < layers.grid.info.shape)).all(axis=1)
    hit, points, cells = hit[inside], points[inside], cells[inside]
    new = layers.distance[cells[:, 0], cells[:, 1]] > WALL_MARGIN
    return hit[new], points[new]


def _spacing(reading: LaserReading) -> float:
    """Return the angle between two beams [rad]."""
    return abs(float(reading.angles[-1] - reading.angles[0])) / max(len(reading.angles) - 1, 1)


def _thing(points: NDArray[np.float64], reading: LaserReading) -> UnmappedObject | None:
    """Return what was hit at some points: the near half of something round."""
    length = float(np.hypot(*(points[-1] - points[0])))
    if length > LARGEST:
        return None
    radius = max(0.5 * length, SMALLEST_RADIUS)
    x, y = points.mean(axis=0).tolist()
    away = math.atan2(y - reading.origin.y, x - reading.origin.x)
    # The mean of a half circle lies so far before its middle.
    behind = 2.0 / math.pi * radius
    return UnmappedObject(x + behind * math.cos(away), y + behind * math.sin(away), radius)
