"""Zones as masks: the cells of a grid that areas touch."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ppaas.maps.grid import GridInfo
from ppaas.zones.shapes import Area
from ppaas.zones.zone import KeepOut, Zone, ZoneSet


def touched(info: GridInfo, area: Area, growth: float = 0.0) -> NDArray[np.bool_]:
    """Return the cells of a grid that an area touches, or that are nearer to it than ``growth`` [m].

    Parameters
    ----------
    info : GridInfo
        Geometry of the grid, in the frame of the map.
    area : Area
    growth : float
        Distance by which the area is extended [m].

    Returns
    -------
    (h, w) bool array
    """
    mask = np.zeros(info.shape, np.bool_)
    window, inside = touched_window(info, area, growth)
    mask[window] = inside
    return mask


def touched_window(info: GridInfo, area: Area, growth: float = 0.0) -> tuple[tuple[slice, slice], NDArray[np.bool_]]:
    """Return a window of rows and columns around an area, and its cells that are `touched`; no other cell is.

    It is meant for many small areas on a large grid.
    """
    reach = growth + 0.5001 * info.resolution * np.sqrt(2.0)
    (low_x, low_y), (high_x, high_y) = area.low - reach, area.high + reach
    corners = info.to_cells([(x, y) for x in (low_x, high_x) for y in (low_y, high_y)])
    first = np.clip(corners.min(axis=0), 0, info.shape)
    last = np.clip(corners.max(axis=0) + 1, 0, info.shape)
    rows, columns = np.mgrid[first[0] : last[0], first[1] : last[1]]
    centres = info.to_world(np.stack((rows, columns), axis=-1).reshape(-1, 2))
    inside = (area.distances(centres) <= reach).reshape(rows.shape)
    return (slice(first[0], last[0]), slice(first[1], last[1])), inside


def kept_out(info: GridInfo, zones: Iterable[Zone]) -> NDArray[np.bool_] | None:
    """Return the cells of a grid that robots keep out of, (h, w) bool; None if no zone is of that kind."""
    masks = [touched(info, zone.area) for zone in zones if isinstance(zone.rule, KeepOut)]
    return np.logical_or.reduce(masks) if masks else None


def closed_zones(zones: ZoneSet, now: float) -> list[Zone]:
    """Return the keep-out zones with times that are in force at a time [s since the epoch]."""
    return [zone for zone in zones.in_force(now) if isinstance(zone.rule, KeepOut) and zone.rule.times]
