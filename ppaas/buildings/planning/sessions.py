"""Lift rides that a robot has begun: a new plan keeps them unless another route is clearly faster."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ppaas.buildings.planning.routes import Route, RouteEnd, RouteStart, alternatives
from ppaas.buildings.planning.times import STEP, BuildingTimes
from ppaas.errors import InvalidInput

MARGIN = 15.0
"""Time by which another route must be faster than the one with the ride that was begun [s]."""


@dataclass(frozen=True, slots=True)
class Session:
    """Ride that a robot has begun.

    Parameters
    ----------
    lift : str
    floor : str
        Floor at which the robot waits, or on which it entered the car.
    inside : bool
        Whether it is in the car.
    to : str
        Floor to which the car was sent; empty if it was not.
    """

    lift: str
    floor: str
    inside: bool = False
    to: str = ""


def starts_from_car(times: BuildingTimes, session: Session, margin: float = MARGIN) -> list[RouteStart]:
    """Return the starts of a robot in a car: all landings of its lift, of which others than ``to`` cost a margin.

    Raises
    ------
    InvalidInput
        There is no such floor or lift.
    """
    network, found = times.network, list[RouteStart]()
    if session.floor not in network.number_of:
        raise InvalidInput(f"there is no floor {session.floor!r}")
    for landing in network.of_lift(session.lift):
        floor = network.junctions[landing].floor
        ride = network.ride(session.lift, network.number_of[session.floor], landing)
        other = session.to not in ("", network.floors[floor])
        seconds = np.full(len(network.parts[floor]), np.inf)
        seconds[landing - network.parts[floor].start] = times.seconds_of(ride) + (margin if other else 0.0)
        found.append(RouteStart(floor, seconds, landing=landing))
    if not found:
        raise InvalidInput(f"there is no lift {session.lift!r} that stops on two floors")
    return found


def without_margin(times: BuildingTimes, route: Route, session: Session, margin: float = MARGIN) -> Route:
    """Return a route from a car with the time that it really takes."""
    floor = times.network.floors[route.start.floor]
    return route if session.to in ("", floor) else replace(route, seconds=route.seconds - margin)


def with_begun_first(
    times: BuildingTimes, starts: Sequence[RouteStart], goal: RouteEnd, routes: Sequence[Route], session: Session,
    *, margin: float = MARGIN,
) -> list[Route]:  # fmt: skip
    """Return routes, the best first, of a robot that waits for a lift.

    The best one that begins with this lift comes first unless the best of all is faster by more than the margin.
    """
    kept = next(iter(alternatives(times, starts, goal, 1, session.lift)), None)
    if kept is None or not routes or kept.seconds > routes[0].seconds + margin + STEP:
        return list(routes)
    others = (each for each in routes if each.chain.names != kept.chain.names)
    return [kept, *others][: len(routes)]
