"""Zones of a map and masks of costmap filters, as one mask of each of Nav2's filters."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.exports.ros2.robot import MapToExport
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.nodes.map_server.costmap_filters import KEEPOUT_FILTER, SPEED_FILTER, SpeedFilterParameters
from ppaas.parameters import read_parameters
from ppaas.zones.masks import touched
from ppaas.zones.zone import AnyRule, Dock, KeepOut, Mark, SpeedZone, Zone

ROUNDED = 1e-9
"""Part of a percent by which a limit may be below a whole one by rounding."""

FULL = 100
"""Percentage of no limit."""

ALWAYS = "a filter of Nav2 has no times: it is in force always"

NO_RULE = "Nav2 has no such rule of traffic"

NO_MARK = "no filter of Nav2 knows marks of a map"


@dataclass(frozen=True)
class Masks:
    """Masks in the cells of the map.

    Parameters
    ----------
    keepout : GridMap or None
        100 is forbidden, 1 to 99 are avoided the more the higher they are.
    speed : GridMap or None
        Limit as a percentage of the maximum speed; 0 for none.
    """

    keepout: GridMap | None = None
    speed: GridMap | None = None


def masks_of(map_: MapToExport | None, filters: Mapping[str, Any], top_speed: float, report: ImportReport) -> Masks:
    """Return the masks of a map, and report what became of each zone.

    Parameters
    ----------
    map_ : MapToExport or None
    filters : mapping
        Parameters of the robot's costmap filters, by their names.
    top_speed : float
        Maximum speed of the robot [m/s].
    report : ImportReport
        It gets an entry for each zone and each mask.
    """
    if map_ is None:
        return Masks()
    drawing = _Drawing(map_.grid.info, top_speed, report)
    for zone in map_.zones.zones:
        drawing.add_zone(zone)
    for name, mask in map_.masks.items():
        drawing.add_mask(name, mask, filters)
    return drawing.masks()


class _Drawing:
    """Both masks while zones and masks are drawn into them."""

    def __init__(self, info: GridInfo, top_speed: float, report: ImportReport) -> None:
        self._info = info
        self._top_speed = top_speed
        self._report = report
        self._keepout = np.zeros(info.shape, np.int8)
        self._speed = np.zeros(info.shape, np.int8)

    def masks(self) -> Masks:
        """Return the masks; one without any value is none."""
        return Masks(*(GridMap(mask, self._info) if mask.any() else None for mask in (self._keepout, self._speed)))

    def add_zone(self, zone: Zone) -> None:
        """Draw a zone, and report it."""
        rule, part = zone.rule, f"zone {zone.name}"
        when = f"; {ALWAYS}" if rule.times else ""
        if isinstance(rule, KeepOut):
            self._keepout[touched(self._info, zone.area)] = OCCUPIED
            self._report.translated(part, f"cells of keepout_mask{when}")
        elif isinstance(rule, SpeedZone):
            percent = self._percent(rule)
            if percent < FULL:
                self._limit(touched(self._info, zone.area), percent)
            text = f"{percent} % in speed_mask{when}" if percent < FULL else "the robot is never faster"
            self._report.translated(part, text)
        elif isinstance(rule, Dock):
            self._report.translated(part, "a dock in docks.yaml")
        else:
            why = NO_MARK if isinstance(rule, Mark) else NO_RULE
            self._report.without_effect(part, f"{why}: {_kind(rule)}")

    def add_mask(self, name: str, mask: GridMap, filters: Mapping[str, Any]) -> None:
        """Draw the mask of a filter of the robot, which may have other cells than its map."""
        values = _resampled(mask, self._info)
        if name == KEEPOUT_FILTER:
            np.maximum(self._keepout, values, out=self._keepout)
            self._report.translated(name, "cells of keepout_mask")
            return
        read = read_parameters(SpeedFilterParameters, SPEED_FILTER, filters.get(SPEED_FILTER, {}))
        limits = read.base + read.multiplier * values.astype(np.float64)
        percent = limits if read.type == 1 else FULL * limits / self._top_speed
        whole = np.clip(np.floor(percent + ROUNDED), 1, FULL).astype(np.int8)
        self._limit((values > 0) & (whole < FULL), whole)
        self._report.translated(name, "percentages of the maximum speed in speed_mask")

    def _percent(self, rule: SpeedZone) -> int:
        """Return a limit in whole percents of the maximum speed, rounded down, so that no robot is faster."""
        percent = rule.percent if rule.max_speed is None else FULL * rule.max_speed / self._top_speed
        return min(FULL, max(1, math.floor((percent or 0.0) + ROUNDED)))

    def _limit(self, where: NDArray[np.bool_], percent: int | NDArray[np.int8]) -> None:
        """Lower the limit of some cells."""
        before = np.where(self._speed == 0, FULL, self._speed)
        self._speed[where] = np.minimum(before, percent)[where]


def _kind(rule: AnyRule) -> str:
    return str(rule.__struct_config__.tag)


def _resampled(mask: GridMap, info: GridInfo) -> NDArray[np.int8]:
    """Return the values of a mask at the centres of the cells of a map; 0 outside it."""
    rows, columns = np.mgrid[: info.height, : info.width]
    places = mask.info.to_cells(info.to_world(np.stack((rows, columns), axis=-1).reshape(-1, 2)))
    inside = ((places >= 0) & (places < mask.info.shape)).all(axis=1)
    values = np.zeros(len(places), np.int8)
    values[inside] = np.maximum(mask.data[tuple(places[inside].T)], FREE)  # unknown cells forbid nothing
    return values.reshape(info.shape)
