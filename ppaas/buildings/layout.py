"""Layout of a building: where its lifts, doors and ways are on each floor, joined from the zones of its maps."""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ppaas.buildings.building import Building
from ppaas.polygons import Points, distances_to_edges
from ppaas.zones.shapes import Point, lines_of, polygons_of
from ppaas.zones.zone import Dock, Door, LiftCar, OneWay, Passage, Zone, ZoneSet

Place = tuple[float, float, float]
"""x, y [m], yaw [rad] in the frame of the map of a floor."""

BEFORE_DOOR = 0.9
"""Distance from a door at which a robot waits [m]."""


@dataclass(frozen=True, slots=True)
class DoorPlace:
    """Door on a floor.

    Parameters
    ----------
    floor, door : str
        Floor, and name of the door.
    ends : pair of pairs of float
        Both ends of the line that is closed by it [m].
    lift : str
        Lift whose car is behind it; empty if it leads to another part of the floor.
    one_way : float, optional
        Only direction in which robots pass through it [rad].
    """

    floor: str
    door: str
    ends: tuple[tuple[float, float], tuple[float, float]]
    lift: str = ""
    one_way: float | None = None

    @property
    def middle(self) -> tuple[float, float]:
        """Middle between its ends [m]."""
        (x0, y0), (x1, y1) = self.ends
        return 0.5 * (x0 + x1), 0.5 * (y0 + y1)

    def may_pass(self, heading: float) -> bool:
        """Return whether robots may pass through it with a heading [rad]."""
        return self.one_way is None or math.cos(heading - self.one_way) >= 0.0


@dataclass(frozen=True, slots=True)
class Landing:
    """Place where a lift stops on a floor: a door of the car there.

    Parameters
    ----------
    lift, floor : str
    door : DoorPlace
        Door between floor and car.
    car : Place
        Middle of the car; its heading leads out through the door.
    outline : tuple of pairs of float
        Floor of the car [m], without the first corner again.
    wait : Place
        Where a robot waits before the door, with its heading into the car.
    """

    lift: str
    floor: str
    door: DoorPlace
    car: Place
    outline: tuple[tuple[float, float], ...]
    wait: Place


@dataclass(frozen=True, slots=True)
class WayEnd:
    """End of stairs, a ramp or a bridge on a floor: where robots enter it, with their heading."""

    way: str
    floor: str
    place: Place


@dataclass(frozen=True, slots=True)
class DockPlace:
    """Dock on a floor, as `ppaas.zones.zone.Dock` has it."""

    floor: str
    dock: str
    place: Place
    dock_type: str
    charges: bool


@dataclass(frozen=True, slots=True)
class BuildingLayout:
    """Places of a building on its floors.

    Parameters
    ----------
    building : Building
    landings : mapping of str to tuple of Landing
        Landings of each lift, in the order of the floors of the building.
    ways : mapping of str to tuple of WayEnd
        Ends of each way: two of them.
    doors : tuple of DoorPlace
        All doors, also of lifts.
    docks : tuple of DockPlace
    warnings : tuple of str
        What is left out, or may be wrong: each with floor and name.
    """

    building: Building
    landings: Mapping[str, tuple[Landing, ...]]
    ways: Mapping[str, tuple[WayEnd, ...]]
    doors: tuple[DoorPlace, ...]
    docks: tuple[DockPlace, ...]
    warnings: tuple[str, ...]


def layout_of(building: Building, zones: Mapping[str, ZoneSet]) -> BuildingLayout:
    """Return the layout of a building.

    Parameters
    ----------
    building : Building
    zones : mapping of str to ZoneSet
        Zones of the map of each floor, by the name of the floor; a floor that is missing has none.
    """
    warnings: list[str] = []
    doors = [door for floor, zone in _each(building, zones, Door) for door in _doors(floor, zone, zones[floor])]
    landings = _landings(building, zones, doors, warnings)
    ways: defaultdict[str, list[WayEnd]] = defaultdict(list)
    for floor, zone in _each(building, zones, Passage):
        assert isinstance(zone.rule, Passage)
        ways[zone.rule.way].append(WayEnd(zone.rule.way, floor, (*_point(zone), zone.rule.yaw)))
    complete = {way: tuple(ends) for way, ends in ways.items() if _is_complete(way, ends, warnings)}
    docks = tuple(
        DockPlace(floor, zone.name, (*_point(zone), zone.rule.yaw), zone.rule.dock_type, zone.rule.charges)
        for floor, zone in _each(building, zones, Dock)
        if isinstance(zone.rule, Dock)
    )
    _warn_of_unused(building, landings, complete, doors, warnings)
    return BuildingLayout(building, landings, complete, tuple(doors), docks, tuple(warnings))


def _each(building: Building, zones: Mapping[str, ZoneSet], kind: type) -> Iterator[tuple[str, Zone]]:
    for floor in building.floors:
        for zone in zones[floor.name].zones if floor.name in zones else ():
            if isinstance(zone.rule, kind):
                yield floor.name, zone


def _point(zone: Zone) -> tuple[float, float]:
    assert isinstance(zone.geometry, Point)
    x, y = zone.geometry.coordinates[:2]
    return x, y


def _doors(floor: str, zone: Zone, zones: ZoneSet) -> Iterator[DoorPlace]:
    assert isinstance(zone.rule, Door)
    for line in lines_of(zone.geometry):
        door = DoorPlace(floor, zone.name, ((line[0][0], line[0][1]), (line[-1][0], line[-1][1])), zone.rule.lift)
        yield door if door.lift else replace(door, one_way=_direction_at(door.middle, zones))


def _direction_at(place: tuple[float, float], zones: ZoneSet) -> float | None:
    """Return the direction of a one-way zone that is always in force at a place [rad]; None if there is none."""
    point = np.array([place])
    for zone in zones.zones:
        rule = zone.rule
        if isinstance(rule, OneWay) and not rule.times and zone.area.distances(point)[0] == 0.0:
            if rule.direction is not None and not zone.area.lines:
                return rule.direction
            [(x, y)] = zone.area.directions(point).tolist()
            return math.atan2(y, x)
    return None


# -- lifts -------------------------------------------------------------------------------------------------------------


def _landings(
    building: Building, zones: Mapping[str, ZoneSet], doors: list[DoorPlace], warnings: list[str]
) -> dict[str, tuple[Landing, ...]]:
    cars: dict[tuple[str, str], Zone] = {}
    for floor, zone in _each(building, zones, LiftCar):
        assert isinstance(zone.rule, LiftCar)
        key = zone.rule.lift_id, floor
        if key in cars:
            warnings.append(f"floor {floor!r}: two zones are the car of lift {key[0]!r}; {zone.name!r} is left out")
        else:
            cars[key] = zone
    found: defaultdict[str, list[Landing]] = defaultdict(list)
    for (lift, floor), car in cars.items():
        own = [door for door in doors if (door.lift, door.floor) == (lift, floor)]
        if not own:
            warnings.append(f"floor {floor!r}: lift {lift!r} has no door there; draw a door with lift {lift!r}")
        found[lift] += [_landing(lift, car, door) for door in own]
    for lift, places in tuple(found.items()):
        if len({landing.floor for landing in places}) < 2:
            warnings.append(f"lift {lift!r} stops on one floor only: robots do not take it")
            del found[lift]
    return {lift: tuple(places) for lift, places in found.items()}


def _landing(lift: str, car: Zone, door: DoorPlace) -> Landing:
    ring = np.array([place[:2] for place in polygons_of(car.geometry)[0][0]])
    corners = ring[:-1] if np.array_equal(ring[0], ring[-1]) else ring
    middle = _centroid(corners)
    outward = _outward(door, middle)
    yaw = math.atan2(outward[1], outward[0])
    x, y = np.asarray(door.middle) + BEFORE_DOOR * outward
    inward = math.atan2(-outward[1], -outward[0])
    centre = float(middle[0]), float(middle[1]), yaw
    outline = tuple((float(one[0]), float(one[1])) for one in corners)
    return Landing(lift, door.floor, door, centre, outline, (float(x), float(y), inward))


def _outward(door: DoorPlace, middle: Points) -> Points:
    """Return the unit vector across a door, away from the middle of the car."""
    along = np.subtract(door.ends[1], door.ends[0])
    across = np.array((-along[1], along[0])) / max(float(np.hypot(*along)), 1e-9)
    away = np.asarray(door.middle) - middle
    outward: Points = across if across @ away >= 0.0 else -across
    return outward


def _centroid(corners: Points) -> Points:
    """Return the centre of the area of a polygon of (n, 2) corners, (2,)."""
    following = np.roll(corners, -1, axis=0)
    cross = corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]
    area = cross.sum()
    if abs(area) < 1e-9:
        return np.asarray(corners.mean(axis=0))
    return np.asarray(((corners + following) * cross[:, np.newaxis]).sum(axis=0) / (3.0 * area))


# -- checks ------------------------------------------------------------------------------------------------------------

NEAR_CAR = 1.0
"""Distance from the outline of a car up to which a door is taken for its door [m]."""


def _is_complete(way: str, ends: list[WayEnd], warnings: list[str]) -> bool:
    if len(ends) == 2 and ends[0].floor != ends[1].floor:
        return True
    floors = ", ".join(repr(end.floor) for end in ends)
    warnings.append(f"way {way!r} needs one end on each of two floors, and has them on {floors}: it is left out")
    return False


def _warn_of_unused(
    building: Building,
    landings: Mapping[str, tuple[Landing, ...]],
    ways: Mapping[str, tuple[WayEnd, ...]],
    doors: list[DoorPlace],
    warnings: list[str],
) -> None:
    for lift in building.lifts:
        if lift.lift not in landings:
            warnings.append(f"no two maps have a landing of lift {lift.lift!r}: its settings have no effect")
    for way in building.ways:
        if way.way not in ways:
            warnings.append(f"no maps have both ends of way {way.way!r}: its settings have no effect")
    known = {(door.floor, door.door) for door in doors}
    for door in building.doors:
        if (door.floor, door.door) not in known:
            warnings.append(f"floor {door.floor!r} has no door {door.door!r}: its settings have no effect")
    for landing in (each for places in landings.values() for each in places):
        ring = np.array(landing.outline)
        apart = distances_to_edges(ring, np.roll(ring, -1, axis=0), np.array(landing.door.middle)).min()
        if apart > NEAR_CAR:
            warnings.append(
                f"floor {landing.floor!r}: door {landing.door.door!r} is {apart:.1f} m from the car of lift "
                f"{landing.lift!r}: check where it is drawn"
            )
