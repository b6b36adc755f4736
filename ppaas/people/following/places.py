"""Places of a map: where a robot can stand to follow a person, where people can walk, and what is in sight."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.maps.grid import FREE, OCCUPIED_THRESHOLD, GridInfo
from ppaas.maps.raycast import cast_rays
from ppaas.people.talking_groups import Points, distances_to

# -- places of a map ---------------------------------------------------------------------------------------------------

MOST_COST = 128
"""Cost of a place from which an obstacle is about 7 cm farther than it must be; Move Base sees obstacles a little
larger than they are on the map."""


class Places:
    """Questions about the map of a robot. Only the neighbourhood of a point is read.

    Parameters
    ----------
    layers : MapLayers
        The map, inflated for the robot.
    """

    def __init__(self, layers: MapLayers) -> None:
        self._layers = layers

    def standable(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether the robot can stand at each of (n, 2) points x, y [m]."""
        costmap = self._layers.costmap
        cells = costmap.info.to_cells(points)
        inside = ((cells >= 0) & (cells < costmap.info.shape)).all(axis=1)
        free = np.zeros(len(cells), np.bool_)
        rows, columns = cells[inside].T
        free[inside] = costmap.data[rows, columns] < MOST_COST
        return free

    def sight(self, origin: Pose2D, angles: ArrayLike, most: float) -> NDArray[np.float64]:
        """Return how far one sees from a pose in directions relative to its heading [rad], up to ``most`` [m]."""
        window = self._window(origin.x, origin.y, most)
        if window is None:
            return np.full(np.shape(angles), most)
        cells, info = window
        return np.minimum(cast_rays(cells >= OCCUPIED_THRESHOLD, info, origin, angles, most), most)

    def sees(self, one: tuple[float, float], other: tuple[float, float]) -> bool:
        """Return whether no wall is between two points x, y [m]."""
        apart = math.dist(one, other)
        heading = math.atan2(other[1] - one[1], other[0] - one[0])
        return bool(self.sight(Pose2D(*one, heading), [0.0], apart + 0.05)[0] >= apart)

    def walkable(self, x: float, y: float, reach: float, size: float) -> tuple[NDArray[np.bool_], GridInfo] | None:
        """Return the cells around a point in which people can walk: known cells without an obstacle.

        Parameters
        ----------
        x, y : float
            The point [m].
        reach : float
            Half the edge of the square around it [m].
        size : float
            Least edge of a cell [m], rounded to a number of cells of the map.

        Returns
        -------
        (h, w) array of bool and GridInfo, or None
            None outside the map.
        """
        window = self._window(x, y, reach)
        if window is None:
            return None
        cells, info = window
        factor = max(round(size / info.resolution), 1)
        height, width = (-(-edge // factor) for edge in cells.shape)
        padded = np.zeros((height * factor, width * factor), np.bool_)
        padded[: cells.shape[0], : cells.shape[1]] = (cells >= FREE) & (cells < OCCUPIED_THRESHOLD)
        free = np.logical_and.reduce(padded.reshape(height, factor, width, factor), axis=(1, 3))
        return free, GridInfo(info.resolution * factor, width, height, info.origin)

    def _window(self, x: float, y: float, reach: float) -> tuple[NDArray[np.int8], GridInfo] | None:
        """Return the cells of the map within ``reach`` of a point along its axes, and their geometry."""
        info = self._layers.grid.info
        row, column = info.to_cells((x, y)).tolist()
        margin = math.ceil(reach / info.resolution) + 1
        low = max(row - margin, 0), max(column - margin, 0)
        high = min(row + margin + 1, info.height), min(column + margin + 1, info.width)
        if high[0] <= low[0] or high[1] <= low[1]:
            return None
        corner = info.origin @ Pose2D(low[1] * info.resolution, low[0] * info.resolution)
        size = high[1] - low[1], high[0] - low[0]
        return self._layers.grid.data[low[0] : high[0], low[1] : high[1]], GridInfo(info.resolution, *size, corner)


# -- choice of the place at which a robot follows a person -------------------------------------------------------------

TURNS = 24
"""Number of directions from the person that are tried."""

RADII = (1.0, 0.75, 1.35)
"""Distances tried, relative to the one wanted."""

LEAST = 0.6
"""Least distance from the person [m]."""

GROUP_MARGIN = 0.7
"""Distance that a place keeps from the space between people who talk [m]."""

ROBOT_MARGIN = 0.6
"""Distance that a place keeps from other robots [m]."""

SIDE, NEARER, TRAVEL, CHANGE = 1.0, 1.5, 0.15, 0.4
"""Costs: of a direction off the wanted side [1/rad], of another distance [1/m], of the distance to drive [1/m], and of
another direction than before [1/rad]."""

NOBODY: Points = np.empty((0, 2))


@dataclass(frozen=True, slots=True)
class StandingRequest:
    """What a place has to suit.

    Parameters
    ----------
    person : tuple of float
        Position of the person, x, y [m].
    robot : Pose2D
    distance : float
        Wanted distance from the person [m].
    wanted : float
        Wanted direction from the person to the place [rad].
    last : float or None
        Direction from the person to the place before [rad].
    path : tuple of float or None
        Place on the path that the person walked, x, y [m]; it is taken if it is free.
    people, robots : (n, 2) arrays
        Positions of other people and other robots [m].
    personal_space : float
        Distance from other people [m].
    groups : sequence of (n, 2) arrays
        Members of groups who talk.
    failed : (n, 2) array
        Places that the robot could not reach.
    """

    person: tuple[float, float]
    robot: Pose2D
    distance: float
    wanted: float
    last: float | None = None
    path: tuple[float, float] | None = None
    people: Points = field(default_factory=NOBODY.copy)
    robots: Points = field(default_factory=NOBODY.copy)
    personal_space: float = 0.8
    groups: Sequence[Points] = ()
    failed: Points = field(default_factory=NOBODY.copy)


FAILED_RADIUS = 0.4
"""Distance from a place that was not reached within which no other is chosen [m]."""


def choose_place(request: StandingRequest, places: Places) -> tuple[float, float] | None:
    """Return the best place x, y [m]; None if none is free."""
    if request.path is not None and _suits(np.array([request.path]), request, places)[0]:
        return request.path
    angles = request.wanted + np.linspace(0.0, 2.0 * math.pi, TURNS, endpoint=False)
    radii = np.array([max(part * request.distance, LEAST) for part in RADII])
    sight = places.sight(Pose2D(*request.person), angles, float(radii.max()))
    angle, radius, seen = (each.ravel() for each in np.broadcast_arrays(angles[:, None], radii, sight[:, None]))
    points = np.stack((np.cos(angle), np.sin(angle)), axis=1) * radius[:, None] + request.person
    suits = (seen >= radius - 1e-6) & _suits(points, request, places)
    if not suits.any():
        return None
    costs = _costs(points, angle, radius, request)
    x, y = points[int(np.argmin(np.where(suits, costs, np.inf)))].tolist()
    return x, y


def _suits(points: Points, request: StandingRequest, places: Places) -> NDArray[np.bool_]:
    suits = places.standable(points) & (distances_to(points, request.groups) >= GROUP_MARGIN)
    limits = (
        (request.people, request.personal_space), (request.robots, ROBOT_MARGIN), (request.failed, FAILED_RADIUS),
    )  # fmt: skip
    for others, least in limits:
        suits &= (np.hypot(*(points[:, None] - others).transpose(2, 0, 1)) >= least).all(axis=1)
    return suits


def _costs(
    points: Points, angle: NDArray[np.float64], radius: NDArray[np.float64], request: StandingRequest
) -> NDArray[np.float64]:
    costs = SIDE * _off(angle, request.wanted) + NEARER * np.abs(radius - request.distance)
    costs += TRAVEL * np.hypot(*(points - request.robot[:2]).T)
    if request.last is not None:
        costs += CHANGE * _off(angle, request.last)
    return costs


def _off(angles: NDArray[np.float64], other: float) -> NDArray[np.float64]:
    return np.abs((angles - other + math.pi) % (2.0 * math.pi) - math.pi)


def facing(place: tuple[float, float], person: tuple[float, float]) -> Pose2D:
    """Return the pose at a place x, y [m] that faces a person."""
    return Pose2D(*place, wrap_angle(math.atan2(person[1] - place[1], person[0] - place[0])))
