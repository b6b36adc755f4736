"""Where plans lie: their ends, and where they pass near two places."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.plans.encoding.index_cells import Position
from ppaas.plans.stored import LARGEST_TOLERANCE


def check_search(start: Position, goal: Position, tolerance: float) -> None:
    """Raise ``InvalidInput`` unless plans can be looked for between these places [m]."""
    if not all(map(math.isfinite, (*start, *goal))):
        raise InvalidInput(f"plans are looked for between two finite places, not from {start} to {goal}")
    if not 0.0 <= tolerance <= LARGEST_TOLERANCE:
        raise InvalidInput(f"tolerance: {tolerance!r} is not between 0 and {LARGEST_TOLERANCE} m")


def joins(first: Position, last: Position, start: Position, goal: Position, tolerance: float) -> bool:
    """Tell whether a plan from ``first`` to ``last`` has both ends within ``tolerance`` of two places [m]."""
    return math.dist(first, start) <= tolerance and math.dist(last, goal) <= tolerance


def comes_near(points: NDArray[np.float64], place: Position, tolerance: float) -> bool:
    """Tell whether one of (n, 2) points lies within a tolerance of a place [m]."""
    return bool((np.hypot(*(points - place).T) <= tolerance).any())


def passage(points: NDArray[np.float64], start: Position, goal: Position, tolerance: float) -> tuple[int, int] | None:
    """Return where a plan passes near one place and later near another.

    Parameters
    ----------
    points : (n, 2) array
        x, y of its waypoints [m].
    start, goal : tuple of float
        The places [m].
    tolerance : float
        How near is near [m].

    Returns
    -------
    tuple of int or None
        Of the waypoints near the start that have a later one near the goal, the one nearest to it, and of those later
        ones the one nearest to the goal; the first where some are equally near.
    """
    to_start = np.hypot(*(points - start).T)
    to_goal = np.hypot(*(points - goal).T)
    near_goal = np.flatnonzero(to_goal <= tolerance)
    if not near_goal.size:
        return None
    near_start = np.flatnonzero(to_start[: near_goal[-1]] <= tolerance)
    if not near_start.size:
        return None
    first = int(near_start[np.argmin(to_start[near_start])])
    later = near_goal[near_goal > first]
    return first, int(later[np.argmin(to_goal[later])])


def length_between(points: NDArray[np.float64], first: int, last: int) -> float:
    """Return the length of a plan from one of its waypoints to another [m]."""
    steps = np.diff(points[first : last + 1], axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
