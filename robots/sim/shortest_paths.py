"""Ways through a map from anywhere to anywhere, and how one is gone along."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas import planners
from ppaas.costmap.costmap import FREE_SPACE, LETHAL_OBSTACLE, Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.planners.base import PlanRequest
from robots.sim.courses import drivable

Points = NDArray[np.float64]

TRIES = 32


class ShortestPaths:
    """Where one may be in a map, and how one gets from here to there.

    Parameters
    ----------
    grid : GridMap
    clearance : float
        Least distance of every way from walls [m].
    rng : numpy.random.Generator
        Decides where `anywhere` is.

    Raises
    ------
    InvalidMap
        There is no room.
    """

    def __init__(self, grid: GridMap, clearance: float, rng: np.random.Generator) -> None:
        self._rng = rng
        self._info = grid.info
        self._where = drivable(grid, clearance, rng)
        self._cells = np.argwhere(self._where)
        self._costmap = Costmap(np.where(self._where, FREE_SPACE, LETHAL_OBSTACLE).astype(np.uint8), grid.info)
        self._planner = planners.create("dijkstra")

    def anywhere(self) -> Pose2D:
        """Return a pose that one may have."""
        cell = self._cells[self._rng.integers(len(self._cells))]
        x, y = self._info.to_world(cell).tolist()
        return Pose2D(x, y, float(self._rng.uniform(-math.pi, math.pi)))

    def away_from(self, place: Pose2D, distance: float) -> Pose2D:
        """Return a pose that is so far from a place [m], where the map is large enough."""
        found = self.anywhere()
        for _ in range(TRIES):
            if found.distance_to(place) >= distance:
                break
            found = self.anywhere()
        return found

    def allows(self, x: float, y: float) -> bool:
        """Tell whether one may be there [m]."""
        cell = self._info.cell_of(x, y)
        return cell is not None and bool(self._where[cell])

    def nearest(self, place: Pose2D) -> Pose2D:
        """Return the pose nearest to a place where one may be."""
        row, column = self._info.to_cells(place[:2])
        rows, columns = self._cells.T
        cell = self._cells[np.argmin((rows - row) ** 2 + (columns - column) ** 2)]
        x, y = self._info.to_world(cell).tolist()
        return Pose2D(x, y, place.theta)

    def between(self, start: Pose2D, goal: Pose2D) -> Points:
        """Return the points of the shortest way, (n, 2) x, y [m].

        Raises
        ------
        PlanningError
            One of both is where one may not be.
        """
        return self._planner.plan(self._costmap, PlanRequest(start, goal)).poses[:, :2]


class PathWalk:
    """How far one has come along the points of a way.

    Parameters
    ----------
    points : (n, 2) array
        x, y [m].
    """

    def __init__(self, points: Points) -> None:
        self._points = points
        self._at = 0

    @property
    def come(self) -> int:
        """How many of its points were come to."""
        return self._at

    @property
    def ended(self) -> bool:
        """Whether its last point was come to."""
        return self._at >= len(self._points) - 1

    def ahead(self, x: float, y: float, distance: float) -> tuple[float, float]:
        """Return the point to go for from a place, so far ahead [m]; what lies before it was come to."""
        gaps = np.hypot(*(self._points[self._at :] - (x, y)).T)
        # Where the way comes back near to here later, that part is not come to yet.
        away = np.flatnonzero(gaps > 2.0 * distance)
        part = gaps[: away[0]] if len(away) else gaps
        if len(part):
            within = np.flatnonzero(part < distance)
            self._at += int(within[-1] if len(within) else np.argmin(part))
        right, up = self._points[self._at].tolist()
        return right, up
