"""Shortest paths on a map, and the progress of a walk along one."""

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
"""Random poses tried in search of a distant one."""


class ShortestPaths:
    """Random poses on a map and shortest paths between them.

    Parameters
    ----------
    grid : GridMap
        The map.
    clearance : float
        Least distance of all paths from walls [m].
    rng : numpy.random.Generator
        Random generator of the poses.

    Raises
    ------
    InvalidMap
        The map has no free region with this clearance.
    """

    def __init__(self, grid: GridMap, clearance: float, rng: np.random.Generator) -> None:
        self._rng = rng
        self._info = grid.info
        self._allowed = drivable(grid, clearance, rng)
        self._cells = np.argwhere(self._allowed)
        self._costmap = Costmap(np.where(self._allowed, FREE_SPACE, LETHAL_OBSTACLE).astype(np.uint8), grid.info)
        self._planner = planners.create("dijkstra")

    def anywhere(self) -> Pose2D:
        """Return a random allowed pose."""
        cell = self._cells[self._rng.integers(len(self._cells))]
        x, y = self._info.to_world(cell).tolist()
        return Pose2D(x, y, float(self._rng.uniform(-math.pi, math.pi)))

    def away_from(self, place: Pose2D, distance: float) -> Pose2D:
        """Return a random allowed pose at a distance [m] or more from a pose, if one is found."""
        found = self.anywhere()
        for _ in range(TRIES):
            if found.distance_to(place) >= distance:
                break
            found = self.anywhere()
        return found

    def allows(self, x: float, y: float) -> bool:
        """Return whether a point [m] is allowed."""
        cell = self._info.cell_of(x, y)
        return cell is not None and bool(self._allowed[cell])

    def nearest(self, place: Pose2D) -> Pose2D:
        """Return the allowed pose nearest to a pose."""
        row, column = self._info.to_cells(place[:2])
        rows, columns = self._cells.T
        cell = self._cells[np.argmin((rows - row) ** 2 + (columns - column) ** 2)]
        x, y = self._info.to_world(cell).tolist()
        return Pose2D(x, y, place.theta)

    def between(self, start: Pose2D, goal: Pose2D) -> Points:
        """Return the points of the shortest path, (n, 2) x, y [m].

        Raises
        ------
        PlanningError
            The start or the goal is not allowed.
        """
        return self._planner.plan(self._costmap, PlanRequest(start, goal)).poses[:, :2]


class PathWalk:
    """Progress along the points of a path.

    Parameters
    ----------
    points : (n, 2) array
        x, y [m].
    """

    def __init__(self, points: Points) -> None:
        self._points = points
        self._at = 0

    @property
    def reached(self) -> int:
        """Index of the last point reached."""
        return self._at

    @property
    def ended(self) -> bool:
        """Whether the last point was reached."""
        return self._at >= len(self._points) - 1

    def ahead(self, x: float, y: float, distance: float) -> tuple[float, float]:
        """Return the point to steer for, up to ``distance`` ahead of a position [m], and mark it as reached."""
        distances = np.hypot(*(self._points[self._at :] - (x, y)).T)
        # A later part of the path that returns close to here must not count as reached.
        away = np.flatnonzero(distances > 2.0 * distance)
        part = distances[: away[0]] if len(away) else distances
        if len(part):
            within = np.flatnonzero(part < distance)
            self._at += int(within[-1] if len(within) else np.argmin(part))
        to_x, to_y = self._points[self._at].tolist()
        return to_x, to_y
