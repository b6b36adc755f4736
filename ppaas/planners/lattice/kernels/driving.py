"""Kernel: drive along an arc or a straight piece over a costmap: what it costs, and whether the robot fits.

All is in cells: x along the columns, y along the rows, the cell (row, column) from (column, row) to one further.
A point is looked at at most a cell after the one before, and where two follow each other diagonally both cells beside
them must be open too: so no cell is crossed that was not looked at, and the cells of a drive are a path of the grid.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE as BLOCKED
from ppaas.cost_values import LETHAL_OBSTACLE as LETHAL

Floats = NDArray[np.float64]

STEP = 0.95
"""Most that any part of the robot moves between two looks [cells]: less than one, so that nothing slips through."""


class Ground(NamedTuple):
    """What is driven on, and who drives.

    ``costs`` (height, width) uint8 array: ``BLOCKED`` to the robot's centre, ``LETHAL`` to any part of it; ``rates``
    (256,): what a cell's length costs by it. ``corners`` (n, 2): the robot's convex outline, counter-clockwise, and
    ``reach`` its furthest corner; ``sums`` (height, width + 1) int32: lethal cells before each, along its row; both
    empty for a robot that is its centre alone. ``outside``: whether the outline may stick out of the map. A robot
    that begins in a blocked cell may go ``escape`` far from ``x``, ``y`` until it is free.
    """

    costs: NDArray[np.uint8]
    rates: Floats
    corners: Floats
    reach: float
    sums: NDArray[np.int32]
    outside: bool
    x: float
    y: float
    escape: float


class Reached(NamedTuple):
    """Where a drive ended, what it cost (infinite in a collision), and whether the robot still is to be freed."""

    cost: float
    x: float
    y: float
    theta: float
    leaving: bool


@njit(cache=True, nogil=True, error_model="numpy")
def fits(ground: Ground, x: float, y: float, cosine: float, sine: float) -> bool:
    """Tell whether the robot's outline touches no lethal cell, from its lowest row to its highest."""
    corners, sums = ground.corners, ground.sums
    count = len(corners)
    low, high = math.inf, -math.inf
    for corner in range(count):
        at = y + sine * corners[corner, 0] + cosine * corners[corner, 1]
        low, high = min(low, at), max(high, at)
    first, last = math.floor(low), math.floor(high)
    height, width = ground.costs.shape
    if not ground.outside and (first < 0 or last >= height):
        return False
    for row in range(max(first, 0), min(last, height - 1) + 1):
        left, right = math.inf, -math.inf
        for corner in range(count):  # an edge at a time: the part of it that is in this row
            after = corner + 1 if corner + 1 < count else 0
            ax = x + cosine * corners[corner, 0] - sine * corners[corner, 1]
            ay = y + sine * corners[corner, 0] + cosine * corners[corner, 1]
            bx = x + cosine * corners[after, 0] - sine * corners[after, 1]
            by = y + sine * corners[after, 0] + cosine * corners[after, 1]
            if min(ay, by) > row + 1 or max(ay, by) < row:
                continue
            slope = (bx - ax) / (by - ay) if by != ay else 0.0
            begin = bx if by == ay else ax + (min(max(ay, row), row + 1) - ay) * slope
            end = ax if by == ay else ax + (min(max(by, row), row + 1) - ay) * slope
            left, right = min(left, begin, end), max(right, begin, end)
        from_, to = math.floor(left), math.floor(right)
        if not ground.outside and (from_ < 0 or to >= width):
            return False
        from_, to = max(from_, 0), min(to, width - 1)
        if from_ <= to and sums[row, to + 1] > sums[row, from_]:
            return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def looks(ground: Ground, curvature: float, length: float) -> int:
    """Return how many points are looked at on a piece."""
    return max(1, math.ceil(abs(length) * (1.0 + abs(curvature) * ground.reach) / STEP))


@njit(cache=True, nogil=True, error_model="numpy")
def _may_enter(ground: Ground, row: int, column: int, leaving: bool) -> bool:
    inside = 0 <= row < ground.costs.shape[0] and 0 <= column < ground.costs.shape[1]
    return inside and (ground.costs[row, column] < BLOCKED or (leaving and ground.costs[row, column] != LETHAL))


@njit(cache=True, nogil=True, error_model="numpy")
def drive(
    ground: Ground, x: float, y: float, theta: float, curvature: float, length: float, leaving: bool, points: Floats
) -> Reached:
    """Drive along one piece.

    Parameters
    ----------
    ground : Ground
    x, y, theta : float
        Where it begins.
    curvature, length : float
        Of the piece [1/cell, cells]; a negative length is backed up.
    leaving : bool
        Whether the robot still stands in a blocked cell.
    points : (n, 3) array
        Out: x, y, theta of the points looked at; none are written where n is 0.
    """
    count = looks(ground, curvature, length)
    turn = curvature * length / count
    chord = 2.0 * math.sin(0.5 * turn) / curvature if turn != 0.0 else length / count
    dx, dy = chord * math.cos(theta + 0.5 * turn), chord * math.sin(theta + 0.5 * turn)
    cosine, sine = math.cos(turn), math.sin(turn)
    ahead, aside = math.cos(theta), math.sin(theta)
    row, column = math.floor(y), math.floor(x)
    sum_of_rates = 0.0
    for number in range(1, count + 1):
        x += dx
        y += dy
        dx, dy = cosine * dx - sine * dy, sine * dx + cosine * dy
        before, beside = row, column
        row, column = math.floor(y), math.floor(x)
        if not _may_enter(ground, row, column, leaving):
            return Reached(math.inf, x, y, theta, leaving)
        if (row != before and column != beside) and not (
            _may_enter(ground, before, column, leaving) and _may_enter(ground, row, beside, leaving)
        ):
            return Reached(math.inf, x, y, theta, leaving)
        if leaving:
            leaving = ground.costs[row, column] >= BLOCKED
            if leaving and math.hypot(x - ground.x, y - ground.y) > ground.escape:
                return Reached(math.inf, x, y, theta, leaving)
        if len(ground.corners):
            ahead, aside = cosine * ahead - sine * aside, sine * ahead + cosine * aside
            if not fits(ground, x, y, ahead, aside):
                return Reached(math.inf, x, y, theta, leaving)
        sum_of_rates += ground.rates[ground.costs[row, column]]
        if len(points):
            points[number - 1, 0], points[number - 1, 1] = x, y
            points[number - 1, 2] = theta + number * turn
    return Reached(sum_of_rates * abs(length) / count, x, y, theta + curvature * length, leaving)


def level_ground(costs: NDArray[np.uint8]) -> Ground:
    """Return the ground of a robot that is its centre alone, where no cell costs more than another."""
    return Ground(
        costs, np.ones(256), np.empty((0, 2)), 0.0, np.empty((0, 0), np.int32), True, 0.0, 0.0, 0.0
    )  # fmt: skip


def warm() -> None:
    """Compile and call each kernel once."""
    ground = level_ground(np.zeros((9, 9), np.uint8))
    drive(ground, 1.0, 1.0, 0.0, 0.0, 2.0, False, np.empty((0, 3)))
