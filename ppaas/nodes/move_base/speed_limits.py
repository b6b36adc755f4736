"""Speed limits of a robot: from operators (``nav2_msgs/SpeedLimit``), and by place from a mask and from zones."""

import math
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Protocol

import numpy as np

from ppaas.controllers.base import NO_LIMIT, SpeedLimit
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridMap
from ppaas.messages import nav2_msgs
from ppaas.nodes.map_server.costmap_filters import SPEED_FILTER, SpeedFilterParameters
from ppaas.zones.shapes import Area
from ppaas.zones.zone import SpeedZone, Zone, ZoneSet, ZonesInForce

# -- speed limits of a robot -------------------------------------------------------------------------------------------


def limit_of(message: nav2_msgs.SpeedLimit) -> SpeedLimit:
    """Return the limit of a message; 0 means no limit.

    Raises
    ------
    InvalidInput
        The limit is not finite, negative, or more than 100 %.
    """
    value = message.speed_limit
    if not (math.isfinite(value) and value >= 0.0) or (message.percentage and value > 100.0):
        raise InvalidInput(f"speed_limit must be 0 for none, a speed [m/s], or a percentage up to 100, not {value}")
    if value == 0.0:
        return NO_LIMIT
    return SpeedLimit(part=value / 100.0) if message.percentage else SpeedLimit(speed=value)


def lower_of(one: SpeedLimit, other: SpeedLimit) -> SpeedLimit:
    """Return the limit that satisfies both."""
    return SpeedLimit(min(one.speed, other.speed), min(one.part, other.part))


class LimitsByPlace(Protocol):
    """Speed limits by place."""

    def at(self, pose: Pose2D) -> SpeedLimit:
        """Return the limit at a pose of the robot."""
        ...


def without_limits(_layers: MapLayers, _now: Callable[[], float]) -> Sequence[LimitsByPlace]:
    """Return nothing: there are no speed limits by place."""
    return ()


class SpeedLimits:
    """Speed limit of a robot: the last one from an operator, combined with those by place.

    Parameters
    ----------
    places : sequence of LimitsByPlace
        All of them hold.

    Attributes
    ----------
    received : nav2_msgs.SpeedLimit
        Last limit from an operator.
    """

    def __init__(self, places: Sequence[LimitsByPlace] = ()) -> None:
        self.use_places(places)
        self.take(nav2_msgs.SpeedLimit(0.0))

    def use_places(self, places: Sequence[LimitsByPlace]) -> None:
        """Replace the limits by place."""
        self._places = places

    def take(self, message: nav2_msgs.SpeedLimit) -> None:
        """Set the limit of an operator; raises ``InvalidInput`` as `limit_of` does."""
        self._limit, self.received = limit_of(message), message

    def at(self, pose: Pose2D, goal: float = 0.0) -> SpeedLimit:
        """Return the limit at a pose of the robot, including the goal's [m/s]; 0 if that has none."""
        limit = reduce(lower_of, (place.at(pose) for place in self._places), self._limit)
        return lower_of(limit, SpeedLimit(speed=goal)) if goal > 0.0 else limit


class SpeedFilter:
    """Speed limits from the cells of a mask, as in Nav2's speed filter.

    There is no limit in cells that are 0 or unknown, and outside the mask. (Nav2 keeps the last limit in unknown cells
    and outside, so that the speed allowed depends on where the robot came from.)

    Parameters
    ----------
    mask : GridMap
        In the map frame.
    parameters : SpeedFilterParameters
        Conversion of cells into limits.

    Raises
    ------
    InvalidParameter
        The limit of a cell is not above 0, or is more than 100 %.
    """

    def __init__(self, mask: GridMap, parameters: SpeedFilterParameters) -> None:
        self._mask = mask
        p = parameters
        values = np.arange(OCCUPIED + 1)
        limits = p.base + p.multiplier * values
        percent = p.type == 1
        wrong = np.zeros(256, np.bool_)
        wrong[values] = (limits <= 0.0) | ((limits > 100.0) if percent else False)
        wrong[FREE] = False
        if wrong.any() and (found := wrong[mask.data.view(np.uint8)]).any():
            value = int(mask.data[found][0])
            raise InvalidParameter(
                f"{SPEED_FILTER}: cells with value {value} in mask {p.filter_mask!r} give a limit of {limits[value]:g}"
                f"{' %' if percent else ' m/s'}, which must be {'above 0 and at most 100' if percent else 'above 0'}: "
                "change base and multiplier, or the mask; to keep robots out, use keepout_filter"
            )
        self._limits = [
            SpeedLimit(part=limit / 100.0) if percent else SpeedLimit(speed=limit) for limit in limits.tolist()
        ]
        self._limits[FREE] = NO_LIMIT

    def at(self, pose: Pose2D) -> SpeedLimit:
        """Return the limit of the cell of the robot's centre."""
        cell = self._mask.info.cell_of(pose.x, pose.y)
        value = int(self._mask.data[cell]) if cell is not None else FREE
        return self._limits[max(value, FREE)]


# -- speed limits of zones, by the place of a robot and the time -------------------------------------------------------


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
