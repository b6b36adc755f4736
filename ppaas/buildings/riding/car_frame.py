"""Poses in the car of a lift, which stay while the floors pass by.

A car has a landing on each floor, drawn on each map in the frame of that map. A robot that stands in the car has one
place in it, whatever floor it is at: its pose is carried from landing to landing, through the middle of the car.
"""

import math
from collections.abc import Sequence

import numpy as np

from ppaas.buildings.building import Building
from ppaas.buildings.layout import Landing
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.polygons import within_polygon

QUARTER = math.pi / 2.0
"""Doors of a car are in walls at right angles."""


def turn_between(building: Building, origin: Landing, destination: Landing) -> float:
    """Return the angle from the map of one landing to the map of another, by which headings in the car differ [rad].

    The doors as drawn are exact, but a car may have another door on the other floor; the anchors of the floors tell
    which wall it is in, and need to be right to 45° only.
    """
    anchors = building.floor(origin.floor).anchor[2] - building.floor(destination.floor).anchor[2]
    doors = destination.car[2] - origin.car[2]
    quarters = round(wrap_angle(anchors - doors) / QUARTER)
    return wrap_angle(doors + quarters * QUARTER)


def carried(building: Building, origin: Landing, destination: Landing, pose: Pose2D) -> Pose2D:
    """Return the pose on the map of a landing of a robot that has a pose in the car on the map of another one."""
    turn = turn_between(building, origin, destination)
    here = Pose2D(origin.car[0], origin.car[1]).inverse() @ pose
    return Pose2D(destination.car[0], destination.car[1], turn) @ here


def places_in_car(building: Building, landings: Sequence[Landing], landing: Landing) -> list[Pose2D]:
    """Return where robots stand in the car of a lift, on the map of one of its landings; they look out of its door.

    There are as many places as the car holds robots, in rows that give each the most room, side by side if that is as
    good. They are the same places on all floors. Those farthest from the door of the first landing come first.

    Parameters
    ----------
    building : Building
    landings : sequence of Landing
        All landings of the lift.
    landing : Landing
        One of them.
    """
    first, robots = landings[0], building.lift(landing.lift).robots
    middle = Pose2D(*first.car)
    corners = np.array([(middle.inverse() @ Pose2D(x, y, 0.0))[:2] for x, y in first.outline])
    low, size = corners.min(axis=0), np.ptp(corners, axis=0)
    shapes = [(rows, math.ceil(robots / rows)) for rows in range(1, robots + 1)]
    rows, columns = max(shapes, key=lambda shape: round(min(size[0] / shape[0], size[1] / shape[1]), 3))
    across = [low[1] + size[1] * (column + 0.5) / columns for column in range(columns)]
    places = [(low[0] + size[0] * (row + 0.5) / rows, y) for row in range(rows) for y in across][:robots]
    stands = [middle @ Pose2D(float(x), float(y), 0.0) for x, y in places] if robots > 1 else [middle]
    there = [carried(building, first, landing, stand) for stand in stands]
    return [Pose2D(x, y, landing.car[2]) for x, y, _ in there]


def is_inside(landing: Landing, pose: Pose2D) -> bool:
    """Return whether a pose on the map of a landing is within the outline of the car."""
    return bool(within_polygon(np.array(landing.outline), np.array([pose[:2]]))[0])
