"""Visibility: which people the views of robots should show, where walls and other people do not hide them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import LETHAL_OBSTACLE, Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.raycast import cast_rays
from ppaas.messages.people_coordination import SensorView

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

EDGE = 0.06
"""Margin at the sides of a view, in which a body is only partly visible [rad]."""
DEPTH = 0.4
"""Margin at the ends of the range of a view [m]."""
WALL = 0.3
"""Distance by which a wall may be nearer than a person beside it [m]."""
BEHIND = 0.3
"""Least distance between a person and one who hides them [m]."""


@dataclass(frozen=True, slots=True)
class View:
    """View of a sensor in the frame of the map.

    Parameters
    ----------
    robot : int
        Number of its robot.
    pose : Pose2D
    half_angle : float
        Half of the horizontal field of view [rad].
    range_min, range_max : float
        [m]
    """

    robot: int
    pose: Pose2D
    half_angle: float
    range_min: float
    range_max: float


def view_of(robot: int, pose: Pose2D, view: SensorView) -> View:
    """Return a sensor's view in the map, of a robot at a pose."""
    sensor = pose @ Pose2D(view.x, view.y, view.yaw)
    return View(robot, sensor, 0.5 * view.field_of_view, view.range_min, view.range_max)


class Walls:
    """Obstacles of a map that hide people.

    Parameters
    ----------
    costmap : Costmap
    """

    def __init__(self, costmap: Costmap) -> None:
        self._info = costmap.info
        self._occupied = costmap.data == LETHAL_OBSTACLE

    def free_between(self, origin: Pose2D, points: Array, margin: float = WALL) -> Mask:
        """Return whether no wall is between an origin and (n, 2) points [m], apart from the last ``margin`` [m]."""
        off = points - (origin.x, origin.y)
        distances = np.hypot(off[:, 0], off[:, 1])
        if not len(points):
            return np.zeros(0, np.bool_)
        angles = np.arctan2(off[:, 1], off[:, 0])
        start = Pose2D(origin.x, origin.y, 0.0)
        ranges = cast_rays(self._occupied, self._info, start, angles, float(distances.max()))
        free: Mask = ranges >= distances - margin
        return free

    def is_wall(self, points: Array) -> Mask:
        """Return which of (n, 2) points are in a wall [m]; none outside the map."""
        cells = self._info.to_cells(points)
        inside = (cells >= 0).all(axis=1) & (cells < self._info.shape).all(axis=1)
        wall = np.zeros(len(points), np.bool_)
        wall[inside] = self._occupied[cells[inside, 0], cells[inside, 1]]
        return wall


def in_views(views: Sequence[View], people: Array) -> Mask:
    """Return the (V, N) mask of the (N, 2) people [m] who are well within each view, whatever may hide them."""
    if not views or not len(people):
        return np.zeros((len(views), len(people)), np.bool_)
    x, y, yaw, half, near, far = np.array(
        [(v.pose.x, v.pose.y, v.pose.theta, v.half_angle, v.range_min, v.range_max) for v in views]
    ).T[..., np.newaxis]
    east, north = people[:, 0] - x, people[:, 1] - y
    square = east * east + north * north
    ahead = np.cos(yaw) * east + np.sin(yaw) * north
    half = np.where(half >= np.pi - 1e-6, 2.0 * np.pi, np.maximum(half - EDGE, 0.0))
    within = (square > (near + DEPTH) ** 2) & (square < np.maximum(far - DEPTH, 0.0) ** 2)
    narrow = np.arccos(np.clip(ahead / np.sqrt(np.maximum(square, 1e-9)), -1.0, 1.0)) < half
    mask: Mask = within & narrow
    return mask


def hidden_by_people(origin: Pose2D, points: Array, bodies: Array, radius: float) -> Mask:
    """Return which of (n, 2) points [m] are hidden from an origin by the (m, 2) bodies [m] of this radius [m]."""
    off, others = points - (origin.x, origin.y), bodies - (origin.x, origin.y)
    distances = np.hypot(off[:, 0], off[:, 1])
    direction = off / np.maximum(distances, 1e-9)[:, np.newaxis]
    along = direction @ others.T
    across = direction[:, 0, np.newaxis] * others[:, 1] - direction[:, 1, np.newaxis] * others[:, 0]
    before = (along > 0.0) & (along < distances[:, np.newaxis] - BEHIND)
    return np.asarray((before & (np.abs(across) < radius)).any(axis=1), np.bool_)


def visible_pairs(
    views: Sequence[View], walls: Walls, people: Array, wanted: Iterable[int], bodies: Array, *, radius: float
) -> list[tuple[int, int]]:
    """Return the (robot, person) pairs of which the robot should see the person.

    Parameters
    ----------
    views : sequence of View
    walls : Walls
    people : (N, 2) array
        Positions of all people [m].
    wanted : iterable of int
        Numbers of the people to examine.
    bodies : (M, 2) array
        Positions of the people who may hide others [m].
    radius : float
        Radius of their bodies [m].
    """
    numbers = np.array(sorted(wanted), np.intp)
    pairs: set[tuple[int, int]] = set()
    if not len(numbers):
        return []
    within = in_views(views, people[numbers])
    for view, row in zip(views, within, strict=True):
        candidates = numbers[row]
        if not len(candidates):
            continue
        points = people[candidates]
        seen = walls.free_between(view.pose, points) & ~hidden_by_people(view.pose, points, bodies, radius)
        pairs |= {(view.robot, int(person)) for person in candidates[seen]}
    return sorted(pairs)
