"""Doors of a map as walls, so that no path leads through one unawares."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.zones.shapes import lines_of
from ppaas.zones.zone import Door, ZoneSet

Ends = tuple[tuple[float, float], tuple[float, float]]


def door_lines(zones: ZoneSet) -> list[Ends]:
    """Return both ends of each door of a map [m]."""
    return [
        ((line[0][0], line[0][1]), (line[-1][0], line[-1][1]))
        for zone in zones.zones
        if isinstance(zone.rule, Door)
        for line in lines_of(zone.geometry)
    ]


def with_doors_shut(costmap: Costmap, doors: Iterable[Ends]) -> Costmap:
    """Return a read-only costmap in which the cells along these lines are lethal; the same one if there are none."""
    lines = list(doors)
    if not lines:
        return costmap
    shut = replace(costmap, data=costmap.data.copy(), changes=None)
    for (x0, y0), (x1, y1) in lines:
        # Half a cell apart, so that no cell on the line is left out; no path slips between two cells side by side.
        steps = int(np.ceil(np.hypot(x1 - x0, y1 - y0) / (0.5 * costmap.info.resolution))) + 1
        points = np.stack((np.linspace(x0, x1, steps), np.linspace(y0, y1, steps)), axis=1)
        cells = costmap.info.to_cells(points)
        inside = ((cells >= 0) & (cells < costmap.info.shape)).all(axis=1)
        shut.data[tuple(cells[inside].T)] = LETHAL_OBSTACLE
    shut.data.flags.writeable = False
    return shut
