"""Kernel: cost and collision check of one arc or straight piece on a costmap.

Units are cells: x runs along the columns and y along the rows; the cell (row, column) is the square from (column, row)
to (column + 1, row + 1). A piece is sampled at points less than a cell apart. Where two successive points are in
diagonal neighbours, the two cells beside them must be free too. So no crossed cell is missed, and the cells of a drive
form a path on the grid.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE as BLOCKED
from ppaas.cost_values import LETHAL_OBSTACLE as LETHAL
from ppaas.kernel_cache.decorators import compiled

Floats = NDArray[np.float64]

STEP = 0.95
"""Maximum motion of any point of the robot between two samples [cells]: below one, so that no obstacle is missed."""


class DrivingSurface(NamedTuple):
    """The map that is driven on, and the outline of the robot.

    Attributes
    ----------
    costs : (height, width) uint8 array
        Costs. ``BLOCKED`` and above block the robot's centre, ``LETHAL`` blocks any part of it.
    rates : (256,) float64 array
        Cost per length of a cell, by its cost byte [1/cell].
    corners : (n, 2) float64 array
        Corners of the robot's convex outline, counter-clockwise, in its frame [cells]; empty for a point robot.
    reach : float
        Distance of the furthest corner from the robot's origin [cells].
    sums : (height, width + 1) int32 array
        Prefix sums of lethal cells: their number before each column of a row; empty for a point robot.
    outside : bool
        Whether the outline may extend beyond the map.
    x, y : float
        Start of the plan [cells].
    escape : float
        Maximum distance from ``x``, ``y`` within which a robot that starts in a blocked cell must be free [cells].
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


class DriveOutcome(NamedTuple):
    """Result of a drive: cost (infinite after a collision), final pose, and whether the cell is still blocked."""

    cost: float
    x: float
    y: float
    theta: float
    leaving: bool


@compiled
def fits(surface: DrivingSurface, x: float, y: float, cosine: float, sine: float) -> bool:
    """Return whether the robot's outline at x, y touches no lethal cell; the heading is given by cosine and sine.

    The convex outline is scan-converted: for each row, the span of columns that it covers is the range of the edges
    clipped to the row. The prefix sums then tell in constant time whether the span contains a lethal cell.
    """
    corners, sums = surface.corners, surface.sums
    count = len(corners)
    low, high = math.inf, -math.inf
    for corner in range(count):
        at = y + sine * corners[corner, 0] + cosine * corners[corner, 1]
        low, high = min(low, at), max(high, at)
    first, last = math.floor(low), math.floor(high)
    height, width = surface.costs.shape
    if not surface.outside and (first < 0 or last >= height):
        return False
    for row in range(max(first, 0), min(last, height - 1) + 1):
        left, right = math.inf, -math.inf
        for corner in range(count):  # clip each edge to this row
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
        if not surface.outside and (from_ < 0 or to >= width):
            return False
        from_, to = max(from_, 0), min(to, width - 1)
        if from_ <= to and sums[row, to + 1] > sums[row, from_]:
            return False
    return True


@compiled
def sample_count(surface: DrivingSurface, curvature: float, length: float) -> int:
    """Return the number of samples on a piece, at most `STEP` of motion apart for every point of the robot."""
    return max(1, math.ceil(abs(length) * (1.0 + abs(curvature) * surface.reach) / STEP))


@compiled
def _may_enter(surface: DrivingSurface, row: int, column: int, leaving: bool) -> bool:
    inside = 0 <= row < surface.costs.shape[0] and 0 <= column < surface.costs.shape[1]
    return inside and (surface.costs[row, column] < BLOCKED or (leaving and surface.costs[row, column] != LETHAL))


@compiled
def drive(
    surface: DrivingSurface,
    x: float,
    y: float,
    theta: float,
    curvature: float,
    length: float,
    leaving: bool,
    points: Floats,
) -> DriveOutcome:
    """Drive along one piece, and return its end and cost.

    Parameters
    ----------
    surface : DrivingSurface
    x, y, theta : float
        Pose at the begin [cells, rad].
    curvature, length : float
        Curvature [1/cell] and length [cells] of the piece; a negative length is driven in reverse.
    leaving : bool
        Whether the robot is still in a blocked cell, which it started in.
    points : (n, 3) array
        Out: x, y, theta of the samples; not written if n is 0.
    """
    count = sample_count(surface, curvature, length)
    turn = curvature * length / count
    chord = 2.0 * math.sin(0.5 * turn) / curvature if turn != 0.0 else length / count
    dx, dy = chord * math.cos(theta + 0.5 * turn), chord * math.sin(theta + 0.5 * turn)
    cosine, sine = math.cos(turn), math.sin(turn)
    ahead, aside = math.cos(theta), math.sin(theta)
    row, column = math.floor(y), math.floor(x)
    # Samples are equal chords; each is the last one rotated by the same angle, without trigonometric functions.
    sum_of_rates = 0.0
    for number in range(1, count + 1):
        x += dx
        y += dy
        dx, dy = cosine * dx - sine * dy, sine * dx + cosine * dy
        before, beside = row, column
        row, column = math.floor(y), math.floor(x)
        if not _may_enter(surface, row, column, leaving):
            return DriveOutcome(math.inf, x, y, theta, leaving)
        if (row != before and column != beside) and not (
            _may_enter(surface, before, column, leaving) and _may_enter(surface, row, beside, leaving)
        ):
            return DriveOutcome(math.inf, x, y, theta, leaving)
        if leaving:
            leaving = surface.costs[row, column] >= BLOCKED
            if leaving and math.hypot(x - surface.x, y - surface.y) > surface.escape:
                return DriveOutcome(math.inf, x, y, theta, leaving)
        if len(surface.corners):
            ahead, aside = cosine * ahead - sine * aside, sine * ahead + cosine * aside
            if not fits(surface, x, y, ahead, aside):
                return DriveOutcome(math.inf, x, y, theta, leaving)
        sum_of_rates += surface.rates[surface.costs[row, column]]
        if len(points):
            points[number - 1, 0], points[number - 1, 1] = x, y
            points[number - 1, 2] = theta + number * turn
    return DriveOutcome(sum_of_rates * abs(length) / count, x, y, theta + curvature * length, leaving)


def flat_surface(costs: NDArray[np.uint8]) -> DrivingSurface:
    """Return the surface of a point robot on which all cells have the same rate."""
    return DrivingSurface(
        costs, np.ones(256), np.empty((0, 2)), 0.0, np.empty((0, 0), np.int32), True, 0.0, 0.0, 0.0
    )  # fmt: skip


def warm() -> None:
    """Compile and call each kernel once."""
    surface = flat_surface(np.zeros((9, 9), np.uint8))
    drive(surface, 1.0, 1.0, 0.0, 0.0, 2.0, False, np.empty((0, 3)))
