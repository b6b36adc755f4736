"""Geometry of plan searches: plans whose ends, or whose waypoints, pass near two positions."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.plans.encoding.index_cells import Position
from ppaas.plans.stored import LARGEST_TOLERANCE


def check_search(start: Position, goal: Position, tolerance: float) -> None:
    """Raise ``InvalidInput`` unless start and goal are finite [m] and the tolerance is in range [m]."""
    if not all(map(math.isfinite, (*start, *goal))):
        raise InvalidInput(f"start {start} and goal {goal}: coordinates must be finite numbers")
    if not 0.0 <= tolerance <= LARGEST_TOLERANCE:
        raise InvalidInput(f"tolerance: {tolerance!r} is not from 0 to {LARGEST_TOLERANCE} m")


def joins(first: Position, last: Position, start: Position, goal: Position, tolerance: float) -> bool:
    """Return whether a plan from ``first`` to ``last`` has both ends within ``tolerance`` of two positions [m]."""
    return math.dist(first, start) <= tolerance and math.dist(last, goal) <= tolerance


def comes_near(points: NDArray[np.float64], place: Position, tolerance: float) -> bool:
    """Return whether one of (n, 2) points lies within a tolerance of a position [m]."""
    return bool((np.hypot(*(points - place).T) <= tolerance).any())


def passage(points: NDArray[np.float64], start: Position, goal: Position, tolerance: float) -> tuple[int, int] | None:
    """Return the part of a plan that passes near one position and later near another.

    Parameters
    ----------
    points : (n, 2) array
        x, y of its waypoints [m].
    start, goal : tuple of float
        x, y of the positions [m].
    tolerance : float
        Largest distance that counts as near [m].

    Returns
    -------
    tuple of int or None
        Indices of the first and the last waypoint of the part. The first is the waypoint nearest to the start, among
        those followed by a waypoint near the goal. The last is the waypoint after it that is nearest to the goal. Of
        equally near waypoints the first one is taken.
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
    """Return the length of a plan between two of its waypoints [m]."""
    steps = np.diff(points[first : last + 1], axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
