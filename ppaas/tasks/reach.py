"""Reach of robots: the charge that a task takes, with the way back to a charger."""

import math

from ppaas.energy.battery import Battery
from ppaas.energy.sites import Sites
from ppaas.tasks.floors import floor_of
from ppaas.tasks.records import Place, Task

SPEED = 0.5
"""Speed by which distances are estimated as times [m/s]."""

RESERVE = 0.1
"""Charge that a robot keeps when it is back at a charger."""

DETOUR = 1.3
"""Length of a way that was not measured, as a multiple of the straight line."""

RIDE = 30.0
"""Length of a way that a change of floors counts as where it was not measured [m]."""

CONFIRMED_AFTER = 60.0
"""Time after which a hold counts as confirmed, unless another is given [s]."""


def straight(start: Place, goal: Place) -> float:
    """Return the distance between two places as the crow flies [m]; places on two floors are farther apart."""
    ride = 0.0 if floor_of(start) == floor_of(goal) else RIDE
    return math.hypot(goal[0] - start[0], goal[1] - start[1]) + ride


def way_home(place: Place, sites: Sites) -> float:
    """Return about how far it is to the nearest charger [m]; 0 if there is none."""
    return DETOUR * min((straight(place, charger) for charger in sites.chargers.values()), default=0.0)


def cost_of(task: Task, way: float, battery: Battery, sites: Sites) -> float:
    """Return the charge that a task takes from a robot, with the way to it [m] and the way to a charger afterwards.

    Of a patrol one round counts: it is given back before the charge runs out.
    """
    number = len(task.places)
    legs = range(task.leg, task.leg + min(task.legs - task.leg, number))
    places = [task.stops[leg % number] for leg in legs]
    metres = way + DETOUR * sum(map(straight, places, places[1:])) + way_home(places[-1], sites)
    holds = [task.holds[leg % number] for leg in legs] if task.holds else []
    waits = sum(CONFIRMED_AFTER if hold.seconds is None else hold.seconds for hold in holds if hold is not None)
    return battery.cost(metres, metres / SPEED + waits)


def lasts(task: Task, way: float, battery: Battery | None, sites: Sites) -> bool:
    """Return whether a robot has the charge to drive a way [m], to do a task, and to get to a charger.

    One whose battery is not known has, and so has any on a map without chargers.
    """
    return battery is None or not sites.chargers or battery.charge - cost_of(task, way, battery, sites) >= RESERVE


def least_cost(task: Task, battery: Battery, sites: Sites) -> float:
    """Return the charge that a task takes from a robot that begins at the nearest charger."""
    return cost_of(task, way_home(task.target, sites), battery, sites)


def remaining(task: Task, place: Place) -> float:
    """Return about how long the rest of a task takes a robot [s]; more than 0."""
    if task.holding is not None:
        place = task.target
    way = straight(place, task.target)
    stops = task.stops
    left, around = task.legs - task.leg - 1, (*stops[1:], stops[0])
    waits = [0.0 if hold is None else SPEED * (hold.seconds or 0.0) for hold in task.holds] or [0.0] * len(stops)
    steps = [straight(*pair) + wait for *pair, wait in zip(stops, around, waits, strict=True)]
    rounds, rest = divmod(left, len(steps))
    at = task.leg % len(steps)
    way += rounds * sum(steps) + sum((steps * 2)[at : at + rest]) + waits[(task.legs - 1) % len(steps)]
    return max(way / SPEED, 0.001)
