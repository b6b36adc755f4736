"""Zones as masks of the cloud: cells that a robot must not enter, and cells with a speed limit."""

import math
from collections.abc import Sequence

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.wire.vda5050.zones import Zone, Zones
from ppaas.zones.masks import touched_window
from ppaas.zones.shapes import Area, Polygon

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
    areas = [Area(Polygon([[[point.x, point.y] for point in zone.vertices]])) for zone in zones]
    margin = growth + RESOLUTION
    low = np.min([area.low for area in areas], axis=0) - margin
    high = np.max([area.high for area in areas], axis=0) + margin
    resolution = max(RESOLUTION, math.sqrt(float(np.prod(high - low)) / MAX_CELLS))
    columns, rows = (int(n) for n in np.ceil((high - low) / resolution))
    info = GridInfo(resolution, columns, rows, Pose2D(float(low[0]), float(low[1]), 0.0))
    data = np.zeros((rows, columns), np.int8)
    for area, value in sorted(zip(areas, values, strict=True), key=lambda one: -one[1]):
        window, inside = touched_window(info, area, growth)
        data[window][inside] = value
    return GridMap(data, info)
