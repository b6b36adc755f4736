"""Legs of a route: drives on floors, doors, rides in lifts, and ways, with their lengths and times."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from ppaas.buildings.layout import Landing, Place
from ppaas.buildings.planning.routes import Route, RouteEnd
from ppaas.buildings.planning.sessions import Session
from ppaas.buildings.planning.times import BuildingTimes
from ppaas.geometry import wrap_angle

NOWHERE = -1
"""In place of the number of a junction: the start or the goal."""


@dataclass(frozen=True, slots=True)
class Leg:
    """Part of a route.

    Parameters
    ----------
    kind : {"drive", "door", "lift", "way"}
    floor, to_floor : str
        Floors on which it begins and ends.
    start, goal : Place
        Poses in the frames of the maps of these floors.
    length : float
        Distance that the robot drives [m].
    seconds : float
        Time that it takes [s].
    name : str
        Door, or id of the lift or the way; empty for a drive.
    """

    kind: Literal["drive", "door", "lift", "way"]
    floor: str
    to_floor: str
    start: Place
    goal: Place
    length: float
    seconds: float
    name: str = ""


def legs_of(
    times: BuildingTimes, route: Route, goal: RouteEnd, ends: tuple[Place, Place], session: Session | None = None
) -> list[Leg]:
    """Return the legs of a route.

    Parameters
    ----------
    times : BuildingTimes
    route : Route
    goal : RouteEnd
    ends : (Place, Place)
        Start and goal in the frames of the maps of their floors; the start is not used if the robot is in a car.
    session : Session, optional
        Ride with which it begins, if the robot is in a car.
    """
    return list(_legs(times, route, goal, ends, session))


def _legs(
    times: BuildingTimes, route: Route, goal: RouteEnd, ends: tuple[Place, Place], session: Session | None
) -> Iterator[Leg]:
    network, (at, last) = times.network, ends
    number, floor = NOWHERE, route.start.floor
    if route.start.landing >= 0 and session is not None:
        number = route.start.landing
        ride = _first_ride(times, number, session)
        at = ride.goal
        yield ride
    for following in (*route.chain.junctions, NOWHERE):
        to_floor = goal.floor if following == NOWHERE else network.junctions[following].floor
        place = last if following == NOWHERE else network.junctions[following].place
        if NOWHERE in (number, following) or network.is_driven(number, following):
            metres = _length(times, route, goal, number, following)
            name = network.floors[floor]
            yield Leg("drive", name, name, at, place, metres, metres / times.traveller.speed)
        else:
            place = _turned(place)
            yield _crossing(times, number, following, place)
        number, floor, at = following, to_floor, place


def _length(times: BuildingTimes, route: Route, goal: RouteEnd, number: int, following: int) -> float:
    """Return the length of a drive between two junctions, or from the start, or to the goal [m]."""
    speed, parts = times.traveller.speed, times.network.parts
    if number == NOWHERE:
        if following == NOWHERE:
            return route.start.direct * speed
        return float(route.start.seconds[following - parts[route.start.floor].start]) * speed
    if following == NOWHERE:
        return float(goal.seconds[number - parts[goal.floor].start]) * speed
    floor = times.network.junctions[number].floor
    here = number - parts[floor].start
    return float(times.state.lengths[floor][here, following - parts[floor].start])


def _turned(place: Place) -> Place:
    """Return the pose of a robot that leaves what is entered with this one."""
    x, y, yaw = place
    return x, y, wrap_angle(yaw + math.pi)


def _crossing(times: BuildingTimes, number: int, following: int, out: Place) -> Leg:
    """Return the leg through a door, a lift or a way, which ends with this pose."""
    network = times.network
    here, there = network.junctions[number], network.junctions[following]
    floor, to_floor = network.floors[here.floor], network.floors[there.floor]
    if here.floor == there.floor:
        link = next(each for each in network.doors if (each.start, each.goal) == (number, following))
        return Leg("door", floor, floor, here.place, out, link.metres, times.seconds_of(link), link.name)
    link = times.link_between(number, following)
    kind: Literal["lift", "way"] = "lift" if link.way is None else "way"
    return Leg(kind, floor, to_floor, here.place, out, link.metres, times.seconds_with_wait(link), link.name)


def _first_ride(times: BuildingTimes, landing: int, session: Session) -> Leg:
    """Return the rest of the ride of a robot that is in a car."""
    network, junction = times.network, times.network.junctions[landing]
    ride = network.ride(session.lift, network.number_of[session.floor], landing)
    assert isinstance(junction.of, Landing)
    return Leg(
        "lift", session.floor, network.floors[junction.floor], junction.of.car, _turned(junction.place),
        ride.metres, times.seconds_of(ride), session.lift,
    )  # fmt: skip
