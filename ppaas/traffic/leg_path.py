"""Paths along a granted way: straight lines through the centres of cells, and an arc around each corner."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, Poses, poses_along
from ppaas.traffic.granted_way import WayPoint
from ppaas.traffic.room_in_cells import Point

STEP = 0.05
"""Distance of the poses of a path [m]."""


def path_along(leg: Sequence[WayPoint], spacing: float, pose: Pose2D, goal: Pose2D | None = None) -> Poses:
    """Return the path of a robot along a leg of its way, from the nearest point of the leg on, (n, 7).

    Parameters
    ----------
    leg : sequence of WayPoint
        From behind the robot to where it stops; at least one. Its curved points have neighbours on both sides.
    spacing : float
        Distance of neighbouring cells [m]; curves begin and end at half of it.
    pose : Pose2D
        Pose of the robot.
    goal : Pose2D, optional
        Pose in which it is to stop, in the last cell of the leg.
    """
    points = np.array([*_points(leg, spacing), *([] if goal is None else [(goal.x, goal.y)])])
    dense = _with_steps(points)
    nearest = int(np.argmin(np.hypot(dense[:, 0] - pose.x, dense[:, 1] - pose.y)))
    rest = dense[nearest:]
    if len(rest) == 1:
        rest = np.concatenate([[[pose.x, pose.y]], rest])
    return poses_along(rest, None if goal is None else goal.theta)


def _points(leg: Sequence[WayPoint], spacing: float) -> Iterator[Point]:
    for index, here in enumerate(leg):
        if here.curved and 0 < index < len(leg) - 1:
            yield from _curve(leg[index - 1], here, leg[index + 1], spacing)
        else:
            yield here.point


def _curve(before: WayPoint, here: WayPoint, after: WayPoint, spacing: float) -> Iterator[Point]:
    """Yield points of the arc that touches both lines of a corner, at most half a spacing from it.

    Its radius is at most a spacing: then robots that keep that distance from both lines keep it from the arc too.
    """
    come, go = _unit(before, here), _unit(here, after)
    turn = math.atan2(come[0] * go[1] - come[1] * go[0], come[0] * go[0] + come[1] * go[1])
    half = math.tan(abs(turn) / 2.0)
    radius = min(spacing / 2.0 / half, spacing)
    begin = here.x - radius * half * come[0], here.y - radius * half * come[1]
    side = math.copysign(1.0, turn)
    for angle in np.linspace(0.0, abs(turn), max(math.ceil(radius * abs(turn) / STEP), 2)).tolist():
        along, across = radius * math.sin(angle), side * radius * (1.0 - math.cos(angle))
        yield begin[0] + along * come[0] - across * come[1], begin[1] + along * come[1] + across * come[0]


def _unit(one: WayPoint, other: WayPoint) -> Point:
    dx, dy = other.x - one.x, other.y - one.y
    length = math.hypot(dx, dy)
    return dx / length, dy / length


def _with_steps(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points no farther than `STEP` from each other along the lines between points, each once."""
    lengths = np.hypot(*np.diff(points, axis=0).T)
    far = np.append(True, lengths > 1e-6)
    points, lengths = points[far], lengths[far[1:]]
    along = np.append(0.0, np.cumsum(lengths))
    places = np.unique(np.append(np.arange(0.0, along[-1], STEP), along))
    return np.stack([np.interp(places, along, points[:, k]) for k in (0, 1)], axis=1)
