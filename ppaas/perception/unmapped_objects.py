"""Detection of unmapped objects: round objects up to a person's size in a scan that are not in the map."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.costmap.obstacle_memory import WALL_MARGIN
from ppaas.maps.grid import UNKNOWN

REACH = 6.0
"""Limit of ranges that are used, since farther objects are hit by too few beams [m]."""
APART = 0.2
"""Gap between the hits of successive beams, beyond their spacing, from which they belong to two objects [m]."""
LEAST = 3
"""Least number of beams that hit an object."""
LARGEST = 1.0
"""Largest length of an object [m]."""
SMALLEST_RADIUS = 0.1
"""Least radius of an object [m]."""


class UnmappedObject(NamedTuple):
    """Round object that is not in the map, in the frame of the map [m]."""

    x: float
    y: float
    radius: float


def unmapped_objects_in(reading: LaserReading, layers: MapLayers) -> list[UnmappedObject]:
    """Return the unmapped objects in a scan.

    Parameters
    ----------
    reading : LaserReading
        Scan in the frame of the map.
    layers : MapLayers
        Layers of the map.
    """
    hit, points = _unmapped_hits(reading, layers)
    if not len(hit):
        return []
    near = np.hypot(*np.diff(points, axis=0).T) < APART + 2.0 * _spacing(reading) * reading.ranges[hit[1:]]
    parts = np.split(np.arange(len(hit)), np.flatnonzero(~near) + 1)
    if len(parts) > 1 and np.hypot(*(points[0] - points[-1])) < APART:
        # The last and the first beam of a laser with a field of view of 360° are neighbours.
        parts = [np.concatenate((parts[-1], parts[0])), *parts[1:-1]]
    found = (_object_at(points[part], reading) for part in parts if len(part) >= LEAST)
    return [each for each in found if each is not None]


def _unmapped_hits(reading: LaserReading, layers: MapLayers) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the indices of beams that hit no obstacle of the map, and the points that they hit, (n, 2) x, y [m].

    Beams that end where the map is unknown are left out: they hit a wall that is not mapped yet, and a moving robot
    sees another part of it in every scan.
    """
    with np.errstate(invalid="ignore"):
        hit = np.flatnonzero((reading.ranges > 0.0) & (reading.ranges < REACH))
    heading = reading.angles[hit] + reading.origin.theta
    points = np.array(reading.origin[:2]) + reading.ranges[hit, None] * np.stack(
        (np.cos(heading), np.sin(heading)), axis=1
    )
    new = unmapped(points, layers)
    return hit[new], points[new]


def unmapped(points: NDArray[np.float64], layers: MapLayers, margin: float = WALL_MARGIN) -> NDArray[np.bool_]:
    """Return which points are in free space of the map, as (n,) array.

    Parameters
    ----------
    points : (n, 2) array
        x, y in the frame of the map [m].
    layers : MapLayers
        Layers of the map.
    margin : float
        Distance from obstacles of the map up to which a point is on them [m].
    """
    cells = layers.grid.info.to_cells(points)
    inside = np.asarray(((cells >= 0) & (cells < layers.grid.info.shape)).all(axis=1))
    rows, columns = cells[inside].T
    inside[inside] = np.logical_and(layers.distance[rows, columns] > margin, layers.grid.data[rows, columns] != UNKNOWN)
    return inside


def _spacing(reading: LaserReading) -> float:
    """Return the angle between two beams [rad]."""
    return abs(float(reading.angles[-1] - reading.angles[0])) / max(len(reading.angles) - 1, 1)


def _object_at(points: NDArray[np.float64], reading: LaserReading) -> UnmappedObject | None:
    """Return the disc whose near half was hit at these points; None if it is too long."""
    length = float(np.hypot(*(points[-1] - points[0])))
    if length > LARGEST:
        return None
    radius = max(0.5 * length, SMALLEST_RADIUS)
    x, y = points.mean(axis=0).tolist()
    away = math.atan2(y - reading.origin.y, x - reading.origin.x)
    # The centroid of a semicircle is at 2/π of the radius from its centre, towards the laser.
    behind = 2.0 / math.pi * radius
    return UnmappedObject(x + behind * math.cos(away), y + behind * math.sin(away), radius)
