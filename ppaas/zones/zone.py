"""Zones of a map and their rules, as features of GeoJSON, and which of them are in force."""

import math
from collections import defaultdict
from collections.abc import Sequence
from typing import Annotated, Literal, get_args

import msgspec
from msgspec import Meta

from ppaas.errors import InvalidZones
from ppaas.zones.schedule import Hours, is_in_force, next_limit, time_zone_of
from ppaas.zones.shapes import Area, Geometry, Point, check_geometry, lines_of, polygons_of

MOST_ZONES, MOST_POSITIONS, MOST_HOURS = 500, 20_000, 50
"""Largest numbers of zones of a map but marks, of positions of all zones, and of hours of a zone."""

MOST_MARKS = 2000
"""Largest number of zones that are marks, such as stations: nothing is computed for them."""

MOST_ON_LANES = 2000
"""Largest number of positions of all zones of the kind ``lane``."""

MOST_CAPACITIES = 60
"""Largest number of zones of the kind ``capacity``: the zones of a cell are bits of a number."""

LONGEST_NAME = 64


class Rule(msgspec.Struct, frozen=True, tag_field="kind", forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """Rule of a zone.

    Parameters
    ----------
    name : str
        Name of the zone, which no other zone of the map has.
    times : list of Hours
        When it is in force; always if empty.
    time_zone : str, optional
        Time zone of its times; the set's if it has none.
    """

    name: Annotated[str, Meta(min_length=1, max_length=LONGEST_NAME)]
    times: Annotated[list[Hours], Meta(max_length=MOST_HOURS)] = []
    time_zone: str | None = None


class KeepOut(Rule, frozen=True, tag="keep_out"):
    """No part of a robot enters the zone."""


class SpeedZone(Rule, frozen=True, tag="speed_limit"):
    """Robots drive no faster while a part of them is in the zone.

    Parameters
    ----------
    max_speed : float, optional
        Limit [m/s].
    percent : float, optional
        Limit as a percentage of each robot's maximum speed. One of both is given.
    """

    max_speed: Annotated[float, Meta(gt=0.0, le=100.0)] | None = None
    percent: Annotated[float, Meta(gt=0.0, le=100.0)] | None = None


class OneWay(Rule, frozen=True, tag="one_way"):
    """Robots of the traffic do not drive against the direction of the zone; crossing it is allowed.

    Parameters
    ----------
    direction : float, optional
        Direction in the map's frame [rad], of a polygon. A line has its own.
    width : float, optional
        Width of the lane along a line [m].
    strict : bool
        Whether robots may not cross it either, and drive along the direction alone.
    """

    direction: float | None = None
    width: Annotated[float, Meta(gt=0.0, le=100.0)] | None = None
    strict: bool = False


class Lane(Rule, frozen=True, tag="lane"):
    """Line along which robots of the traffic drive; on a map with lanes they drive nowhere else.

    Parameters
    ----------
    one_way : bool
        Whether they drive only in the order of its positions.
    """

    one_way: bool = False


class NoStop(Rule, frozen=True, tag="no_stop"):
    """Robots of the traffic enter the zone only when they may leave it again, and do not wait in it."""


class Capacity(Rule, frozen=True, tag="capacity"):
    """At most so many robots of the traffic are in the zone at a time.

    Parameters
    ----------
    robots : int
    """

    robots: Annotated[int, Meta(ge=1, le=1000)]


class Mark(Rule, frozen=True):
    """Place that robots use; no rule of the traffic, and always there."""


Use = Literal["park", "charge", "wait", "pick", "drop", "clean", "dock"]
"""What a station is for."""

Yaw = Annotated[float, Meta(ge=-7.0, le=7.0)]
"""Heading [rad]."""

Name = Annotated[str, Meta(min_length=1, max_length=LONGEST_NAME)]


class Station(Mark, frozen=True, tag="station"):
    """Named place, where robots are sent.

    Parameters
    ----------
    yaw : float, optional
        Heading of a robot that stands there [rad].
    uses : list of str
        What it is for; any use if empty.
    """

    yaw: Yaw | None = None
    uses: list[Use] = []


class Door(Mark, frozen=True, tag="door"):
    """Door: a line across the way, from one side of the opening to the other.

    Parameters
    ----------
    lift : str
        Id of the lift whose car is behind it; empty if it leads to another part of the floor.
    """

    lift: Annotated[str, Meta(max_length=LONGEST_NAME)] = ""


class LiftCar(Mark, frozen=True, tag="lift"):
    """Floor of the car of a lift while it stops on this map.

    Parameters
    ----------
    lift : str
        Id of the lift in its building; the name of the zone if empty.
    """

    lift: Annotated[str, Meta(max_length=LONGEST_NAME)] = ""

    @property
    def lift_id(self) -> str:
        """Id of the lift."""
        return self.lift or self.name


class Passage(Mark, frozen=True, tag="passage"):
    """End, on this map, of stairs, a ramp or a bridge to another map.

    Parameters
    ----------
    way : str
        Id of the way in its building; another map has its other end.
    yaw : float
        Heading of a robot that enters the way there [rad]; it leaves the way with the opposite heading.
    """

    way: Name
    yaw: Yaw


class Dock(Mark, frozen=True, tag="dock"):
    """Dock: the place of a robot that is docked.

    Parameters
    ----------
    yaw : float
        Heading of a docked robot [rad].
    dock_type : str
        How robots find it: the name of a detector; the robot's usual one if empty.
    charges : bool
        Whether robots are charged there.
    """

    yaw: Yaw
    dock_type: Annotated[str, Meta(max_length=LONGEST_NAME)] = ""
    charges: bool = True


AnyRule = KeepOut | SpeedZone | OneWay | Lane | NoStop | Capacity | Station | Door | LiftCar | Passage | Dock

KINDS = tuple(str(rule.__struct_config__.tag) for rule in get_args(AnyRule))
"""Names of the kinds of zones."""


class Zone(msgspec.Struct, frozen=True, tag="Feature", rename={"rule": "properties"}):
    """Zone of a map: a feature of GeoJSON.

    Parameters
    ----------
    geometry : Geometry
        In metres in the frame of the map; lines only for ``lane``, ``one_way`` and ``door``, a point for a
        ``station``, ``passage`` or ``dock``.
    rule : Rule
        ``properties`` in JSON.
    """

    geometry: Geometry
    rule: AnyRule

    @property
    def name(self) -> str:
        """Name."""
        return self.rule.name

    @property
    def area(self) -> Area:
        """Area, with a lane around each line."""
        return Area(self.geometry, self.width)

    @property
    def width(self) -> float:
        """Width of the lane along its lines [m]; 0 if it has none."""
        width = self.rule.width if isinstance(self.rule, OneWay) else None
        return width or 0.0


class ZoneSet(msgspec.Struct, frozen=True, tag="FeatureCollection", rename={"zones": "features"}):
    """All zones of a map.

    Parameters
    ----------
    zones : list of Zone
        ``features`` in JSON.
    time_zone : str
        Name of the time zone of the times of all zones that do not name one, in the IANA database.

    Raises
    ------
    InvalidZones
        Two zones have one name, a geometry or a value is not valid, or there are too many.
    """

    zones: list[Zone] = []
    time_zone: str = "UTC"

    def __post_init__(self) -> None:
        """Check what types do not."""
        time_zone_of(self.time_zone)
        marks = sum(isinstance(each.rule, Mark) for each in self.zones)
        if len(self.zones) - marks > MOST_ZONES:
            raise InvalidZones(f"a map may have {MOST_ZONES} zones, not {len(self.zones) - marks}")
        if marks > MOST_MARKS:
            raise InvalidZones(f"a map may have {MOST_MARKS} stations, doors and docks, not {marks}")
        names: set[str] = set()
        for each in self.zones:
            if each.name in names:
                raise InvalidZones(f"two zones have the name {each.name!r}: rename one of them")
            names.add(each.name)
        positions = sum(check_zone(each) for each in self.zones)
        if positions > MOST_POSITIONS:
            raise InvalidZones(f"the zones of a map may have {MOST_POSITIONS} positions, not {positions}")
        on_lanes = sum(len(line) for each in self.lanes for line in lines_of(each.geometry))
        if on_lanes > MOST_ON_LANES:
            raise InvalidZones(f"the lanes of a map may have {MOST_ON_LANES} positions, not {on_lanes}")
        if sum(isinstance(each.rule, Capacity) for each in self.zones) > MOST_CAPACITIES:
            raise InvalidZones(f"a map may have {MOST_CAPACITIES} zones of the kind 'capacity'")

    @property
    def lanes(self) -> list[Zone]:
        """Zones of the kind ``lane``."""
        return [each for each in self.zones if isinstance(each.rule, Lane)]

    @property
    def stations(self) -> list[Zone]:
        """Zones of the kind ``station``."""
        return [each for each in self.zones if isinstance(each.rule, Station)]

    def in_force(self, now: float) -> list[Zone]:
        """Return the zones that are in force at a time [s since the epoch]."""
        return [each for each in self.zones if is_in_force(each.rule.times, time_zone_of(self.time_zone_of(each)), now)]

    def next_change(self, now: float) -> float:
        """Return the first time after ``now`` [s since the epoch] at which others may be in force; infinite if never.

        It is at most two days later.
        """
        hours: defaultdict[str, list[Hours]] = defaultdict(list)
        for each in self.zones:
            hours[self.time_zone_of(each)] += each.rule.times
        changes = (next_limit(times, time_zone_of(name), now) for name, times in hours.items())
        return min(changes, default=math.inf)

    def time_zone_of(self, zone: Zone) -> str:
        """Return the name of the time zone of the times of a zone."""
        return zone.rule.time_zone or self.time_zone


NO_ZONES = ZoneSet()


def check_zone(zone: Zone) -> int:
    """Check a zone by itself, and return the number of its positions; ``InvalidZones`` if it is wrong."""
    positions, rule = check_geometry(zone.geometry, zone.name), zone.rule
    is_line = bool(lines_of(zone.geometry))
    if rule.time_zone is not None:
        time_zone_of(rule.time_zone)
    _check_shape(zone, is_line=is_line)
    if isinstance(rule, Lane):
        _check_lane(zone.name, rule, is_line=is_line)
    if isinstance(rule, SpeedZone) and (rule.max_speed is None) == (rule.percent is None):
        raise InvalidZones(f"zone {zone.name!r} needs either 'max_speed' [m/s] or 'percent'")
    if isinstance(rule, OneWay):
        if is_line and rule.width is None:
            raise InvalidZones(f"zone {zone.name!r}: a one_way line needs its 'width' [m]")
        if not is_line and (rule.direction is None or not math.isfinite(rule.direction)):
            raise InvalidZones(f"zone {zone.name!r}: a one_way polygon needs a 'direction' [rad], 0 along x")
    return positions


_POINTS = (Station, Passage, Dock)


def _check_shape(zone: Zone, *, is_line: bool) -> None:
    rule = zone.rule
    if isinstance(rule, _POINTS) != isinstance(zone.geometry, Point):
        text = "a station, a passage or a dock is a point, and all other zones are areas or lines"
        raise InvalidZones(f"zone {zone.name!r}: {text}")
    if isinstance(rule, Mark) and rule.times:
        raise InvalidZones(f"zone {zone.name!r}: {_a(rule)} has no times; it is a place, and not a rule")
    if is_line and not isinstance(rule, OneWay | Lane | Door):
        raise InvalidZones(f"zone {zone.name!r}: only a lane, a door or a one_way zone may be a line; draw a polygon")
    if isinstance(rule, Door) and len(lines_of(zone.geometry)) != 1:
        raise InvalidZones(f"zone {zone.name!r}: a door is one line, from one side of the opening to the other")
    if isinstance(rule, LiftCar) and len(polygons_of(zone.geometry)) != 1:
        raise InvalidZones(f"zone {zone.name!r}: the car of a lift is one polygon")


def _a(rule: Rule) -> str:
    return f"a {rule.__struct_config__.tag}"


def _check_lane(name: str, rule: Lane, *, is_line: bool) -> None:
    if not is_line:
        raise InvalidZones(f"zone {name!r}: a lane is a line; a polygon with a direction is a one_way zone")
    if rule.times:
        raise InvalidZones(f"zone {name!r}: a lane is always in force; draw a keep_out zone with 'times' over it")


# -- zones in force ----------------------------------------------------------------------------------------------------


class ZonesInForce:
    """Zones of a map that are in force at a time that goes on.

    Parameters
    ----------
    zones : ZoneSet
    """

    def __init__(self, zones: ZoneSet) -> None:
        self._zones = zones
        self._found: Sequence[Zone] | None = None
        self._until = float("-inf")

    def at(self, now: float) -> Sequence[Zone]:
        """Return the zones in force at a time [s since the epoch]: the same object as before until others are."""
        if self._found is None or now >= self._until:
            found, self._until = self._zones.in_force(now), self._zones.next_change(now)
            if found != self._found:
                self._found = found
        assert self._found is not None
        return self._found
