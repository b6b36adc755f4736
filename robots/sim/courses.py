"""Courses of simulated robots: random starts and goals, far enough apart and reachable, reproducible by a seed."""

import math
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import FREE_SPACE, LETHAL_OBSTACLE, Costmap
from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied, reachable
from ppaas.maps.grid import FREE, GridInfo, GridMap
from ppaas.planners.field.cost_field import cost_field
from ppaas.planners.weights import NEUTRAL

Mask = NDArray[np.bool_]
_Cell = tuple[int, int]

_TRIES = 64
"""Random cells tried in search of the largest free region."""
_ATTEMPTS = 20
"""Attempts to place all robots and goals."""


@dataclass(frozen=True, slots=True)
class GoalRules:
    """Constraints on starts and goals.

    Parameters
    ----------
    clearance : float
        Least distance of every path from walls: the robot's radius plus a margin [m].
    starts_apart, goals_apart : float
        Least distance between the starts of two robots, and between goals of different robots [m].
    shortest, preferred : float
        Length of the path to a goal, as fractions of the longest shortest path from the robot's position: at least
        ``shortest``, and at most ``preferred`` if there is such a goal.
    """

    clearance: float = 0.18 + 0.15
    starts_apart: float = 2.0
    goals_apart: float = 1.5
    shortest: float = 1.0 / 3.0
    preferred: float = 0.45


@dataclass(frozen=True, slots=True)
class Course:
    """Course of one robot.

    Parameters
    ----------
    start : Pose2D
        Pose at the start.
    goals : tuple of Pose2D
        Goals in order.
    lengths : tuple of float
        Length of the path to each goal from the one before, along the cells of the map [m].
    """

    start: Pose2D
    goals: tuple[Pose2D, ...]
    lengths: tuple[float, ...]


def drivable(grid: GridMap, clearance: float, rng: np.random.Generator) -> Mask:
    """Return the largest connected free region of a map with a distance to walls.

    Parameters
    ----------
    grid : GridMap
        The map.
    clearance : float
        Least distance from the centre of an occupied cell [m].
    rng : numpy.random.Generator
        Random generator for the starting cells of the search.

    Raises
    ------
    InvalidMap
        No cell is free.
    """
    left: Mask = (grid.data == FREE) & (distance_to_occupied(grid) > clearance)
    free, best = left.copy(), np.zeros_like(left)
    for _ in range(_TRIES):
        if np.count_nonzero(left) <= np.count_nonzero(best):
            break
        cells = np.flatnonzero(left)
        row, column = divmod(int(cells[rng.integers(len(cells))]), left.shape[1])
        part = reachable(free, row, column)
        left &= ~part
        if np.count_nonzero(part) > np.count_nonzero(best):
            best = part
    if not best.any():
        raise InvalidMap(f"the map has no free cell at least {clearance:g} m from every wall")
    return best


def path_lengths(info: GridInfo, where: Mask, cell: _Cell) -> NDArray[np.float64]:
    """Return the length of the shortest path from one cell to each cell [m]; infinite if there is none."""
    costs = np.where(where, FREE_SPACE, LETHAL_OBSTACLE).astype(np.uint8)
    field = cost_field(Costmap(costs, info), cells=cell, allow_unknown=False)
    return field * (info.resolution / NEUTRAL)


class CoursePlanner:
    """Chooses courses for robots on a map.

    Parameters
    ----------
    grid : GridMap
        The map.
    seed : int
        Seed of the courses.
    rules : GoalRules, optional
        Constraints on the courses.

    Raises
    ------
    InvalidMap
        The map has no free region.
    """

    def __init__(self, grid: GridMap, seed: int, rules: GoalRules | None = None) -> None:
        self._rules = rules or GoalRules()
        self._info = grid.info
        self._rng = np.random.default_rng(seed)
        self._where = drivable(grid, self._rules.clearance, self._rng)

    def choose(self, robots: int, goals: int) -> list[Course]:
        """Choose a start and goals for each robot.

        Raises
        ------
        InvalidMap
            The map is too small for this number of robots and goals.
        """
        # On a small map, an early choice may leave no space for a later one.
        for _ in range(_ATTEMPTS - 1):
            with suppress(InvalidMap):
                return self._attempt(robots, goals)
        return self._attempt(robots, goals)

    def _attempt(self, robots: int, goals: int) -> list[Course]:
        starts: list[_Cell] = []
        for _ in range(robots):
            starts.append(self._pick(self._away_from(starts, self._rules.starts_apart), "start"))
        chosen: list[list[_Cell]] = [[] for _ in starts]
        lengths: list[list[float]] = [[] for _ in starts]
        for _ in range(goals):
            for robot, start in enumerate(starts):
                others = [cell for other, cells in enumerate(chosen) if other != robot for cell in cells]
                goal, length = self._next_goal([start, *chosen[robot]][-1], others)
                chosen[robot].append(goal)
                lengths[robot].append(length)
        return [
            Course(self._pose(start), tuple(map(self._pose, cells)), tuple(distances))
            for start, cells, distances in zip(starts, chosen, lengths, strict=True)
        ]

    def _next_goal(self, here: _Cell, others: list[_Cell]) -> tuple[_Cell, float]:
        length = path_lengths(self._info, self._where, here)
        longest = float(length[np.isfinite(length)].max())
        allowed = self._away_from(others, self._rules.goals_apart) & (length >= self._rules.shortest * longest)
        preferred = allowed & (length <= self._rules.preferred * longest)
        goal = self._pick(preferred if preferred.any() else allowed, "goal")
        return goal, float(length[goal])

    def _away_from(self, cells: list[_Cell], distance: float) -> Mask:
        """Return the allowed cells at a distance [m] or more from all given cells."""
        allowed = self._where.copy()
        rows, columns = np.ogrid[: allowed.shape[0], : allowed.shape[1]]
        reach = distance / self._info.resolution
        for row, column in cells:
            allowed &= (rows - row) ** 2 + (columns - column) ** 2 >= reach**2
        return allowed

    def _pick(self, candidates: Mask, what: str) -> _Cell:
        cells = np.flatnonzero(candidates)
        if not len(cells):
            raise InvalidMap(f"the map has no space for another {what}; use fewer robots or goals")
        row, column = divmod(int(cells[self._rng.integers(len(cells))]), candidates.shape[1])
        return row, column

    def _pose(self, cell: _Cell) -> Pose2D:
        x, y = self._info.to_world(cell).tolist()
        return Pose2D(x, y, float(self._rng.uniform(-math.pi, math.pi)))
