"""Speed limits of zones, by the place of a robot and the time."""

from collections.abc import Callable, Sequence

import numpy as np

from ppaas.controllers.base import NO_LIMIT, SpeedLimit
from ppaas.geometry import Pose2D
from ppaas.nodes.move_base.speed_limits import lower_of
from ppaas.zones.shapes import Area
from ppaas.zones.zone import SpeedZone, Zone, ZoneSet, ZonesInForce


class ZoneSpeeds:
    """Speed limits of the zones of a map. A limit holds while a part of the robot is in its zone.

    Parameters
    ----------
    zones : ZoneSet
        Zones of all kinds.
    radius : float
        Radius of the robot [m].
    now : callable
        Returns the time [s since the epoch].
    """

    def __init__(self, zones: ZoneSet, radius: float, now: Callable[[], float]) -> None:
        slow = ZoneSet([zone for zone in zones.zones if isinstance(zone.rule, SpeedZone)], zones.time_zone)
        self._areas = {zone.name: zone.area for zone in slow.zones}
        self._zones = ZonesInForce(slow)
        self._radius, self._now = radius, now
        self._limits: list[tuple[Area, SpeedLimit]] = []
        self._chosen: Sequence[Zone] = ()

    def __bool__(self) -> bool:
        """Return whether there are any."""
        return bool(self._areas)

    def at(self, pose: Pose2D) -> SpeedLimit:
        """Return the limit at a pose of the robot: the lowest speed and part of all zones that it touches."""
        in_force, limit, place = self._zones.at(self._now()), NO_LIMIT, np.array([[pose.x, pose.y]])
        if in_force is not self._chosen:
            self._choose(in_force)
        for area, own in self._limits:
            near = (place[0] >= area.low - self._radius).all() and (place[0] <= area.high + self._radius).all()
            if near and area.distances(place)[0] <= self._radius:
                limit = lower_of(limit, own)
        return limit

    def _choose(self, in_force: Sequence[Zone]) -> None:
        self._chosen, rules = in_force, [zone.rule for zone in in_force]
        self._limits = [(self._areas[rule.name], _limit_of(rule)) for rule in rules if isinstance(rule, SpeedZone)]


def _limit_of(rule: SpeedZone) -> SpeedLimit:
    if rule.max_speed is not None:
        return SpeedLimit(speed=rule.max_speed)
    assert rule.percent is not None, "a speed zone has a speed or a percentage"
    return SpeedLimit(part=rule.percent / 100.0)
