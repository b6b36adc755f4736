"""Visibility: the area of the map where people can be, and which people the views of robots should show."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import LETHAL_OBSTACLE, NO_INFORMATION, Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import FREE, OCCUPIED, GridMap
from ppaas.messages.people_coordination import SensorView

Array = NDArray[np.float64]
# -- visibility --------------------------------------------------------------------------------------------------------

Mask = NDArray[np.bool_]

EDGE = 0.06
"""Margin at the sides of a view, in which a body is only partly visible [rad]."""
DEPTH = 0.4
"""Margin at the ends of the range of a view [m]."""
WALL = 0.3
"""Distance by which a wall may be nearer than a person beside it [m]."""
CELL = 0.1
"""Edge of the cells in which walls are looked up, unless the map's cells are larger [m]."""
BEHIND = 0.3
"""Least distance between a person and one who hides them [m]."""


@dataclass(frozen=True, slots=True)
class PlacedView:
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


def view_of(robot: int, pose: Pose2D, view: SensorView) -> PlacedView:
    """Return a sensor's view in the map, of a robot at a pose."""
    sensor = pose @ Pose2D(view.x, view.y, view.yaw)
    return PlacedView(robot, sensor, 0.5 * view.field_of_view, view.range_min, view.range_max)


class Walls:
    """Obstacles of a map that hide people.

    Parameters
    ----------
    costmap : Costmap
    """

    def __init__(self, costmap: Costmap) -> None:
        self._info = costmap.info
        self._occupied = costmap.data == LETHAL_OBSTACLE
        factor = max(1, round(CELL / costmap.info.resolution))
        height, width = (-(-side // factor) for side in costmap.info.shape)
        blocks = np.zeros((height * factor, width * factor), np.bool_)
        blocks[: costmap.info.height, : costmap.info.width] = self._occupied
        cells = blocks.reshape(height, factor, width, factor).max(axis=(1, 3))
        # A border of free cells, so that what is outside the map can be looked up.
        self._coarse: Mask = np.pad(cells, 1)
        self._edge = costmap.info.resolution * factor

    def free_between(self, origins: Array, points: Array, margin: float = WALL) -> Mask:
        """Return whether no wall is between origins and points, apart from the last ``margin`` [m].

        Rays are sampled twice in each cell of some 0.1 m, which is a wall if any part of it is.

        Parameters
        ----------
        origins : (n, 2) or (2,) array
            x, y [m].
        points : (n, 2) array
            x, y [m].
        margin : float
            [m]
        """
        if not len(points):
            return np.zeros(0, np.bool_)
        start = self._local(np.broadcast_to(origins, points.shape))
        off = self._local(points) - start
        distances = np.hypot(off[:, 0], off[:, 1])
        steps = max(2, math.ceil(2.0 * float(distances.max())))
        reach = np.maximum(distances - margin / self._edge, 0.0) / np.maximum(distances, 1e-9)
        share = np.linspace(0.0, 1.0, steps)[:, np.newaxis] * reach
        columns, rows = ((start[:, axis] + share * off[:, axis]).astype(np.int32) + 1 for axis in (0, 1))
        height, width = self._coarse.shape
        # A ray whose ends are within the grid does not leave it.
        if not (_are_below(height, rows[[0, -1]]) and _are_below(width, columns[[0, -1]])):
            rows, columns = np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)
        hit: Mask = self._coarse.take(rows * width + columns).any(axis=0)
        return ~hit

    def _local(self, points: Array) -> Array:
        """Return positions in the map's own axes [coarse cells]."""
        origin = self._info.origin
        x, y = points[:, 0] - origin.x, points[:, 1] - origin.y
        c, s = math.cos(origin.theta), math.sin(origin.theta)
        return np.stack((c * x + s * y, c * y - s * x), axis=-1) / self._edge

    def is_wall(self, points: Array) -> Mask:
        """Return which of (n, 2) points are in a wall [m]; none outside the map."""
        cells = self._info.to_cells(points)
        inside = (cells >= 0).all(axis=1) & (cells < self._info.shape).all(axis=1)
        wall = np.zeros(len(points), np.bool_)
        wall[inside] = self._occupied[cells[inside, 0], cells[inside, 1]]
        return wall


def _are_below(limit: int, numbers: NDArray[np.int32]) -> bool:
    """Return whether all numbers are from 0 to below a limit."""
    return bool(numbers.min() >= 0 and numbers.max() < limit)


def in_views(views: Sequence[PlacedView], people: Array) -> Mask:
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


def hidden_by_people(
    origins: Array, points: Array, bodies: Array, radius: float, apart_from: Mask | None = None
) -> Mask:
    """Return which of (n, 2) points [m] are hidden from (n, 2) origins [m] by (m, 2) bodies [m] of this radius [m].

    Of the (n, m) pairs ``apart_from``, the body does not hide the point.
    """
    off = points - origins
    distances = np.hypot(off[:, 0], off[:, 1])
    east, north = (off / np.maximum(distances, 1e-9)[:, np.newaxis]).T[..., np.newaxis]
    x, y = bodies[:, 0] - origins[:, 0, np.newaxis], bodies[:, 1] - origins[:, 1, np.newaxis]
    along, across = east * x + north * y, east * y - north * x
    before = (along > 0.0) & (along < distances[:, np.newaxis] - BEHIND)
    hides = before & (np.abs(across) < radius)
    return np.asarray((hides if apart_from is None else hides & ~apart_from).any(axis=1), np.bool_)


def visible_pairs(
    views: Sequence[PlacedView], walls: Walls, people: Array, wanted: Iterable[int], bodies: Array, *, radius: float
) -> list[tuple[int, int]]:
    """Return the (robot, person) pairs of which the robot should see the person.

    Parameters
    ----------
    views : sequence of PlacedView
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
    within, who = np.nonzero(in_views(views, people[numbers]))
    if not len(who):
        return []
    origins = np.array([view.pose[:2] for view in views])[within]
    points = people[numbers[who]]
    seen = walls.free_between(origins, points)
    seen[seen] = ~hidden_by_people(origins[seen], points[seen], bodies, radius)
    return sorted({(views[view].robot, int(numbers[k])) for view, k in zip(within[seen], who[seen], strict=True)})


# -- area of a map in which people can be: reflections in mirrors and windows appear outside of it ---------------------


class MapArea:
    """Free space of a map.

    Parameters
    ----------
    costmap : Costmap
        Its lethal cells and those without information are not free.
    """

    def __init__(self, costmap: Costmap) -> None:
        free = (costmap.data != LETHAL_OBSTACLE) & (costmap.data != NO_INFORMATION)
        self._info = costmap.info
        cells = np.where(free, OCCUPIED, FREE).astype(np.int8)
        self._distances = distance_to_occupied(GridMap(cells, costmap.info), serial=True)

    def distance(self, points: Array) -> Array:
        """Return the distance of (n, 2) points [m] from the free space, about [m]; 0 within it.

        For a point outside the map it is at most the nearest cell's plus the distance from there.
        """
        cells = self._info.to_cells(points)
        inside = np.clip(cells, 0, np.array(self._info.shape) - 1)
        beyond = self._info.resolution * np.hypot(*(cells - inside).T)
        return np.asarray(self._distances[inside[:, 0], inside[:, 1]] + beyond, np.float64)
