"""Network of a building: the places between which robots drive on its floors, and what joins them."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ppaas.buildings.building import Building, WaySettings
from ppaas.buildings.layout import BEFORE_DOOR, BuildingLayout, DoorPlace, Landing, Place, WayEnd
from ppaas.geometry import Pose2D


@dataclass(frozen=True, slots=True)
class Junction:
    """Place on a floor at which robots begin or end to drive there: before a lift, a way or a door.

    Parameters
    ----------
    floor : int
        Number of the floor in the building.
    place : Place
    of : Landing, WayEnd or DoorPlace
        What is there; a door has a junction on either side.
    """

    floor: int
    place: Place
    of: Landing | WayEnd | DoorPlace

    @property
    def is_portal(self) -> bool:
        """Whether it leads to other floors."""
        return not isinstance(self.of, DoorPlace)


@dataclass(frozen=True, slots=True)
class BuildingLink:
    """Way from one junction to another that is not driven on the map of a floor.

    Parameters
    ----------
    start, goal : int
        Numbers of the junctions.
    name : str
        Id of a lift or a way, or name of a door.
    seconds : float
        Time that does not depend on the robot [s].
    metres : float
        Distance that the robot drives [m].
    way : WaySettings, optional
        Settings of a way; None for lifts and doors.
    """

    start: int
    goal: int
    name: str
    seconds: float
    metres: float
    way: WaySettings | None = None


class JunctionChain(NamedTuple):
    """Way from one junction to another.

    Parameters
    ----------
    junctions : tuple of int
        Numbers of the junctions at which something else begins than a drive on a floor, in order.
    names : tuple of str
        Ids of the lifts and ways in the order in which they are taken.
    """

    junctions: tuple[int, ...]
    names: tuple[str, ...]


class BuildingNetwork:
    """Junctions of a building, ordered by floor, and the links between them.

    Parameters
    ----------
    layout : BuildingLayout

    Attributes
    ----------
    floors : tuple of str
        Names of the floors.
    junctions : tuple of Junction
    parts : tuple of range
        Numbers of the junctions of each floor.
    portals : tuple of int
        Numbers of the junctions that lead to other floors.
    links : tuple of BuildingLink
        Lifts and ways, each in every direction in which robots may take it.
    doors : tuple of BuildingLink
        Doors, each in every direction in which robots may pass through it.
    """

    def __init__(self, layout: BuildingLayout) -> None:
        self.layout = layout
        self.floors = tuple(floor.name for floor in layout.building.floors)
        self.number_of = {name: number for number, name in enumerate(self.floors)}
        found = sorted(_junctions(layout, self.number_of), key=lambda each: each.floor)
        self.junctions = tuple(found)
        numbers = np.searchsorted([each.floor for each in found], np.arange(len(self.floors) + 1)).tolist()
        self.parts = tuple(range(*ends) for ends in itertools.pairwise(numbers))
        self.portals = tuple(number for number, each in enumerate(found) if each.is_portal)
        self.links = (*self._rides(), *self._ways())
        self.doors = tuple(self._doors())

    def is_driven(self, one: int, other: int) -> bool:
        """Return whether a move between two junctions is a drive on a floor, through no door."""
        here, there = self.junctions[one], self.junctions[other]
        return here.floor == there.floor and (here.is_portal or here.of is not there.of)

    def of_lift(self, lift: str) -> list[int]:
        """Return the numbers of the landings of a lift."""
        return [n for n, each in enumerate(self.junctions) if isinstance(each.of, Landing) and each.of.lift == lift]

    def ride(self, lift: str, start_floor: int, landing: int) -> BuildingLink:
        """Return the rest of a ride of a robot that is in the car on a floor, to a landing, with its way out."""
        settings, junction = self.layout.building.lift(lift), self.junctions[landing]
        rise = abs(self._elevation(junction.floor) - self._elevation(start_floor))
        return BuildingLink(landing, landing, lift, settings.doors + rise / settings.speed, _boarding(junction))

    def _rides(self) -> Iterator[BuildingLink]:
        for lift in self.layout.landings:
            settings, landings = self.layout.building.lift(lift), self.of_lift(lift)
            for start, goal in ((a, b) for a in landings for b in landings):
                here, there = self.junctions[start], self.junctions[goal]
                if here.floor != there.floor:
                    rise = abs(self._elevation(there.floor) - self._elevation(here.floor))
                    seconds = settings.wait + 2.0 * settings.doors + rise / settings.speed
                    yield BuildingLink(start, goal, lift, seconds, _boarding(here) + _boarding(there))

    def _ways(self) -> Iterator[BuildingLink]:
        ends: dict[str, list[int]] = {way: [] for way in self.layout.ways}
        for number, each in enumerate(self.junctions):
            if isinstance(each.of, WayEnd):
                ends[each.of.way].append(number)
        for name, (one, other) in ends.items():
            way = self.layout.building.way(name)
            length = way.length if way.length is not None else self._apart(one, other)
            for start, goal in ((one, other), (other, one)):
                if way.one_way in ("", self.floors[self.junctions[start].floor]):
                    yield BuildingLink(start, goal, name, 0.0, length, way)

    def _doors(self) -> Iterator[BuildingLink]:
        sides: dict[DoorPlace, list[int]] = {}
        for number, each in enumerate(self.junctions):
            if isinstance(each.of, DoorPlace):
                sides.setdefault(each.of, []).append(number)
        for door, (one, other) in sides.items():
            opens = self.layout.building.door(door.floor, door.door)
            seconds = opens.opens if opens.device else 0.0
            for start, goal in ((one, other), (other, one)):
                if door.may_pass(self.junctions[start].place[2]):
                    yield BuildingLink(start, goal, door.door, seconds, 2.0 * BEFORE_DOOR)

    def _elevation(self, floor: int) -> float:
        return self.layout.building.floors[floor].elevation

    def _apart(self, one: int, other: int) -> float:
        """Return the distance of two junctions in space [m]."""
        here, there = (self._in_building(self.layout.building, self.junctions[each]) for each in (one, other))
        return max(math.dist(here, there), 0.01)

    def _in_building(self, building: Building, junction: Junction) -> tuple[float, float, float]:
        floor = building.floors[junction.floor]
        pose = Pose2D(*floor.anchor) @ Pose2D(*junction.place)
        return pose.x, pose.y, floor.elevation


def _boarding(junction: Junction) -> float:
    assert isinstance(junction.of, Landing)
    return math.dist(junction.of.wait[:2], junction.of.car[:2])


def _junctions(layout: BuildingLayout, number_of: dict[str, int]) -> Iterator[Junction]:
    for landings in layout.landings.values():
        for landing in landings:
            yield Junction(number_of[landing.floor], landing.wait, landing)
    for ends in layout.ways.values():
        for end in ends:
            yield Junction(number_of[end.floor], end.place, end)
    for door in dict.fromkeys(layout.doors):
        if not door.lift:
            for place in sides_of(door):
                yield Junction(number_of[door.floor], place, door)


def sides_of(door: DoorPlace) -> tuple[Place, Place]:
    """Return the places on both sides of a door from which robots drive through it, with their headings."""
    (x0, y0), (x1, y1) = door.ends
    along = math.atan2(y1 - y0, x1 - x0)
    x, y = door.middle
    left = -math.sin(along) * BEFORE_DOOR, math.cos(along) * BEFORE_DOOR
    return (
        (x + left[0], y + left[1], along - math.pi / 2.0),
        (x - left[0], y - left[1], along + math.pi / 2.0),
    )
