"""Zones as masks of the cloud: cells that a robot must not enter, and cells with a speed limit."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.polygons import distances_to_edges
from ppaas.wire.vda5050.zones import Zone, Zones

BARRED = 100
"""Value of a cell that the robot must not enter."""

SPEED_STEP = 0.02
"""Speed of one step of a cell's value [m/s]: limits are rounded down to multiples, and are 2 m/s at most."""

RESOLUTION = 0.1
"""Size of a cell [m]; it grows for zones that are far from each other."""

MAX_CELLS = 4_000_000
"""Largest number of cells of a mask."""


def keepout_mask(zones: Zones) -> GridMap:
    """Return the cells that zones of type BLOCKED touch; one free cell if there are none."""
    blocked = [zone for zone in zones.zones if zone.zone_type == "BLOCKED"]
    return _mask(blocked, [BARRED] * len(blocked), 0.0)


def speed_mask(zones: Zones, radius: float) -> GridMap:
    """Return the speed limits of zones, in steps of `SPEED_STEP`; the lowest counts where zones overlap.

    Zones hold for the outline of a robot and masks for its centre, so zones grow by the ``radius`` of the robot [m].
    """
    limits = [zone for zone in zones.zones if zone.zone_type == "SPEED_LIMIT"]
    return _mask(limits, [min(int((zone.maximum_speed or 0.0) / SPEED_STEP + 1e-9), 100) for zone in limits], radius)


def marked_point(mask: GridMap) -> tuple[float, float] | None:
    """Return the centre of a cell that has an effect [m]; None if none has."""
    rows, columns = np.nonzero(mask.data)
    if not len(rows):
        return None
    middle = len(rows) // 2
    x, y = mask.info.to_world((rows[middle], columns[middle]))
    return float(x), float(y)


def _mask(zones: Sequence[Zone], values: Sequence[int], growth: float) -> GridMap:
    if not zones:
        return GridMap(np.zeros((1, 1), np.int8), GridInfo(RESOLUTION, 1, 1))
    polygons = [np.array([(point.x, point.y) for point in zone.vertices]) for zone in zones]
    corners = np.concatenate(polygons)
    margin = growth + RESOLUTION
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + margin
    resolution = max(RESOLUTION, math.sqrt(float(np.prod(high - low)) / MAX_CELLS))
    columns, rows = (int(n) for n in np.ceil((high - low) / resolution))
    info = GridInfo(resolution, columns, rows, Pose2D(float(low[0]), float(low[1]), 0.0))
    data = np.zeros((rows, columns), np.int8)
    for polygon, value in sorted(zip(polygons, values, strict=True), key=lambda one: -one[1]):
        _draw(GridMap(data, info), polygon, value, growth)
    return GridMap(data, info)


def _draw(mask: GridMap, polygon: NDArray[np.float64], value: int, growth: float) -> None:
    """Set the cells that a polygon touches, and those that are nearer to it than ``growth`` [m]."""
    reach = growth + mask.info.resolution * math.sqrt(0.5) * 1.001
    (bottom, left), (top, right) = mask.info.to_cells((polygon.min(axis=0) - reach, polygon.max(axis=0) + reach))
    rows, columns = np.mgrid[max(bottom, 0) : top + 1, max(left, 0) : right + 1]
    window = mask.data[max(bottom, 0) : top + 1, max(left, 0) : right + 1]
    centres = mask.info.to_world(np.stack((rows, columns), axis=-1))[: window.shape[0], : window.shape[1]]
    x, y = centres[..., 0], centres[..., 1]
    inside, near = np.zeros(x.shape, bool), np.zeros(x.shape, bool)
    for begin, end in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        inside ^= _crosses(x, y, begin, end)
        near |= distances_to_edges(begin, end, centres) <= reach
    window[inside | near] = value


def _crosses(
    x: NDArray[np.float64], y: NDArray[np.float64], begin: NDArray[np.float64], end: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return whether a ray from each point along x crosses an edge."""
    spans = (begin[1] > y) != (end[1] > y)
    if begin[1] == end[1]:
        return np.asarray(spans)
    crossing = begin[0] + (y - begin[1]) / (end[1] - begin[1]) * (end[0] - begin[0])
    return np.asarray(spans & (x < crossing))
