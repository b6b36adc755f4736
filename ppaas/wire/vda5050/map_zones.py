"""Zones of a map as sets of zones of VDA 5050 3.0, and back.

=================  ===============================================================================
zone of a map      zone of VDA 5050
=================  ===============================================================================
``keep_out``       ``BLOCKED``
``speed_limit``    ``SPEED_LIMIT``; a percentage needs the top speed of the AGV
``one_way``        ``DIRECTED``: ``STRICT`` if it is strict, else ``RESTRICTED``
``capacity``       ``RELEASE``: an AGV asks before it enters. The number of robots is not part of it
``no_stop``        none
``lane``           none: AGVs follow the edges of their orders
``station``        left out: it is no rule
=================  ===============================================================================

VDA 5050 has simple polygons only, and no times. So a line is one rectangle for each of its segments, a zone of several
polygons is several zones, and the zones in force at a moment are one set.
"""

import math
from collections.abc import Iterable, Iterator
from itertools import count, pairwise
from typing import Any

import msgspec

from ppaas.decoding import converted
from ppaas.errors import InvalidInput
from ppaas.wire.vda5050 import spelling, topics
from ppaas.wire.vda5050 import zones as wire
from ppaas.wire.vda5050.codec import encode
from ppaas.wire.vda5050.fields import Point
from ppaas.wire.vda5050.headers import MessageHeader, timestamp
from ppaas.wire.vda5050.topics import Version
from ppaas.zones.reading import zones_of
from ppaas.zones.shapes import Position, Ring, lines_of, polygons_of
from ppaas.zones.zone import Capacity, KeepOut, Lane, Mark, NoStop, OneWay, SpeedZone, Zone, ZoneSet

RELEASED = 1
"""Number of robots in a zone of type RELEASE, whose message has none: access is granted to one after the other."""

REQUIRED = {"SPEED_LIMIT": ("maximum_speed",), "DIRECTED": ("direction", "directed_limitation")}
"""Fields that a zone of a type needs."""

_WIRE_NAMES = {one.name: one.encode_name for one in msgspec.structs.fields(wire.Zone)}

Part = tuple[Ring, float | None]
"""Vertices of a polygon, and the direction in it [rad]; None if it has none."""


def zones_of_vda5050(payload: bytes) -> ZoneSet:
    """Return the zones of a map that a set of zones describes.

    Parameters
    ----------
    payload : bytes
        A message of the topic ``zoneSet``, or the object ``zoneSet`` of one alone.

    Raises
    ------
    InvalidInput
        It is no set of zones, or a zone cannot be one of a map; the text names the zone, its type, and why.
    """
    try:
        tree = msgspec.json.decode(payload)
        if isinstance(tree, dict):
            tree = tree.get(topics.ZONE_SET, tree)
        spelling.name_limitations(tree)
        zones = converted(tree, wire.Zones)
    except msgspec.ValidationError as error:
        raise InvalidInput(f"not a zoneSet of VDA 5050 3.0: {error}") from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InvalidInput(f"the zoneSet is not valid JSON: {error}") from error
    features = [_feature(zone) for zone in zones.zones]
    return zones_of(msgspec.json.encode({"type": "FeatureCollection", "features": features}))


def _feature(zone: wire.Zone) -> dict[str, Any]:
    ring = [[point.x, point.y] for point in zone.vertices]
    closed = ring if ring[0] == ring[-1] else [*ring, ring[0]]
    properties = {"name": zone.zone_id, **_properties(zone)}
    return {
        "type": "Feature", "geometry": {"type": "Polygon", "coordinates": [closed]}, "properties": properties
    }  # fmt: skip


def _properties(zone: wire.Zone) -> dict[str, Any]:
    for name in REQUIRED.get(zone.zone_type, ()):
        if getattr(zone, name) is None:
            also = " (limitation in the schema of 3.0.0)" if name == "directed_limitation" else ""
            raise InvalidInput(
                f"zone {zone.zone_id!r} is {zone.zone_type} without the field {_WIRE_NAMES[name]}{also}: add it"
            )
    match zone.zone_type:
        case "BLOCKED":
            return {"kind": "keep_out"}
        case "SPEED_LIMIT":
            return {"kind": "speed_limit", "max_speed": zone.maximum_speed}
        case "RELEASE":
            return {"kind": "capacity", "robots": RELEASED}
        case "DIRECTED" if zone.directed_limitation in ("RESTRICTED", "STRICT"):
            strict = zone.directed_limitation == "STRICT"
            return {"kind": "one_way", "direction": zone.direction, "strict": strict}
        case "DIRECTED":
            kind = f"DIRECTED with the limitation {zone.directed_limitation}, which forbids nothing"
        case _:
            kind = zone.zone_type
    raise InvalidInput(
        f"zone {zone.zone_id!r} is {kind}: a map has zones for BLOCKED, SPEED_LIMIT, RELEASE, and DIRECTED that is "
        "RESTRICTED or STRICT"
    )


def vda5050_of(zones: ZoneSet, map_id: str, zone_set_id: str, now: float, *, top_speed: float | None = None) -> bytes:
    """Return the message ``zoneSet`` of the zones that are in force; its header names no AGV.

    Parameters
    ----------
    zones : ZoneSet
    map_id, zone_set_id : str
    now : float
        Time [s since the epoch].
    top_speed : float, optional
        Top speed of the AGV [m/s], for limits that are percentages.

    Raises
    ------
    InvalidInput
        A zone in force cannot be expressed; the text names all of them, and why.
    """
    expressed, problems = expressed_zones(zones.in_force(now), top_speed)
    if problems:
        raise InvalidInput("; ".join(problems))
    header = MessageHeader(
        header_id=0, timestamp=timestamp(now), version=Version.V3_0.value, manufacturer="", serial_number=""
    )
    body = wire.ZoneSet(zone_set=wire.Zones(map_id=map_id, zone_set_id=zone_set_id, zones=expressed))
    return encode(topics.ZONE_SET, header, body, Version.V3_0)


def expressed_zones(zones: Iterable[Zone], top_speed: float | None = None) -> tuple[list[wire.Zone], list[str]]:
    """Return the zones of VDA 5050, and why others cannot be expressed; a zone is expressed as a whole or not at all.

    Parameters
    ----------
    zones : iterable of Zone
    top_speed : float, optional
        Top speed of the AGV [m/s], for limits that are percentages.
    """
    given = [zone for zone in zones if not isinstance(zone.rule, Mark)]
    taken = {zone.name for zone in given}
    found: list[wire.Zone] = []
    problems: list[str] = []
    for zone in given:
        try:
            fields, parts = _fields(zone, top_speed), _parts(zone)
        except InvalidInput as error:
            problems.append(str(error))
            continue
        for zone_id, (ring, direction) in zip(_ids(zone.name, taken), parts, strict=False):
            vertices = [Point(x=place[0], y=place[1]) for place in ring]
            found.append(wire.Zone(zone_id=zone_id, vertices=vertices, direction=direction, **fields))
    return found, problems


def _ids(name: str, taken: set[str]) -> Iterator[str]:
    """Yield ids of the parts of a zone, which no other zone has: its name, and its name with a number."""
    yield name
    for number in count(2):
        if (found := f"{name}-{number}") not in taken:
            taken.add(found)
            yield found


def _fields(zone: Zone, top_speed: float | None) -> dict[str, Any]:
    match zone.rule:
        case KeepOut():
            return {"zone_type": "BLOCKED"}
        case SpeedZone(max_speed=speed) if speed is not None:
            return {"zone_type": "SPEED_LIMIT", "maximum_speed": speed}
        case SpeedZone(percent=percent) if percent is not None and top_speed is not None:
            return {"zone_type": "SPEED_LIMIT", "maximum_speed": percent / 100.0 * top_speed}
        case SpeedZone():
            raise InvalidInput(
                f"zone {zone.name!r} limits the speed to a percentage, and VDA 5050 has limits in m/s: "
                "the top speed of the AGV must be known"
            )
        case OneWay(strict=strict):
            return {"zone_type": "DIRECTED", "directed_limitation": "STRICT" if strict else "RESTRICTED"}
        case Capacity(robots=robots):
            text = f"at most {robots} robot{'' if robots == 1 else 's'} at a time"
            return {"zone_type": "RELEASE", "release_loss_behavior": "STOP", "zone_descriptor": text}
        case NoStop() | Lane() | Mark():
            kind = "lane" if isinstance(zone.rule, Lane) else "no_stop"
            raise InvalidInput(f"zone {zone.name!r} is of the kind {kind}, which VDA 5050 3.0 does not have")


def _parts(zone: Zone) -> list[Part]:
    rule, polygons = zone.rule, polygons_of(zone.geometry)
    if lines := lines_of(zone.geometry):
        return [_lane(one, other, zone.width) for line in lines for one, other in pairwise(line)]
    if any(len(rings) > 1 for rings in polygons):
        raise InvalidInput(f"zone {zone.name!r} has a hole, and polygons of VDA 5050 have none: divide it")
    if len(polygons) > 1 and isinstance(rule, Capacity):
        raise InvalidInput(f"zone {zone.name!r} counts the robots of several polygons, and VDA 5050 those of one")
    direction = rule.direction if isinstance(rule, OneWay) else None
    return [(_open(rings[0]), direction) for rings in polygons]


def _open(ring: Ring) -> Ring:
    return ring[:-1] if ring[0][:2] == ring[-1][:2] else ring


def _lane(one: Position, other: Position, width: float) -> Part:
    """Return the rectangle around a segment of a line, and the direction of the segment."""
    (x0, y0), (x1, y1) = one[:2], other[:2]
    direction = math.atan2(y1 - y0, x1 - x0)
    aside_x, aside_y = -0.5 * width * math.sin(direction), 0.5 * width * math.cos(direction)
    corners = [
        [x0 - aside_x, y0 - aside_y], [x1 - aside_x, y1 - aside_y],
        [x1 + aside_x, y1 + aside_y], [x0 + aside_x, y0 + aside_y],
    ]  # fmt: skip
    return corners, direction
