"""Slow, obvious twin of driving over a costmap: poses, touched cells, and cost."""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

Pose = tuple[float, float, float]
Corners = Sequence[tuple[float, float]]


def pose_along(start: Pose, curvature: float, length: float) -> Pose:
    """Return the pose at the end of a piece, by rotation about the centre of its circle."""
    x, y, theta = start
    if curvature == 0.0:
        return x + length * math.cos(theta), y + length * math.sin(theta), theta
    after = theta + curvature * length
    centre = x - math.sin(theta) / curvature, y + math.cos(theta) / curvature
    return centre[0] + math.sin(after) / curvature, centre[1] - math.cos(after) / curvature, after


def touches(corners: Corners, row: int, column: int) -> bool:
    """Return whether a convex polygon and a cell intersect, by the separating axis theorem."""
    cell = [(column + i, row + j) for i in (0, 1) for j in (0, 1)]
    edges = [(b[0] - a[0], b[1] - a[1]) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
    for nx, ny in [(1.0, 0.0), (0.0, 1.0), *((-dy, dx) for dx, dy in edges)]:
        ours = [nx * x + ny * y for x, y in corners]
        its = [nx * x + ny * y for x, y in cell]
        if max(ours) < min(its) or max(its) < min(ours):
            return False
    return True


def placed(corners: Corners, pose: Pose) -> list[tuple[float, float]]:
    """Return the corners of a robot at a pose."""
    x, y, theta = pose
    c, s = math.cos(theta), math.sin(theta)
    return [(x + c * a - s * b, y + s * a + c * b) for a, b in corners]


def outline_is_free(lethal: NDArray[np.bool_], corners: Corners, outside: bool) -> bool:
    """Return whether a robot touches no lethal cell, and none outside the map unless ``outside``."""
    height, width = lethal.shape
    xs, ys = [x for x, _ in corners], [y for _, y in corners]
    for row in range(math.floor(min(ys)) - 1, math.floor(max(ys)) + 2):
        for column in range(math.floor(min(xs)) - 1, math.floor(max(xs)) + 2):
            inside = 0 <= row < height and 0 <= column < width
            bad = bool(lethal[row, column]) if inside else not outside
            if bad and touches(corners, row, column):
                return False
    return True


def points(start: Pose, curvature: float, length: float, reach: float) -> Iterator[Pose]:
    """Yield the sampled poses along a piece: no part of the robot moves by more than 0.95 cells between two."""
    count = max(1, math.ceil(abs(length) * (1 + abs(curvature) * reach) / 0.95))
    for number in range(1, count + 1):
        yield pose_along(start, curvature, length * number / count)


def drive(
    costs: NDArray[np.uint8],
    rates: NDArray[np.float64],
    start: Pose,
    piece: tuple[float, float],
    corners: Corners = (),
    outside: bool = True,
) -> float:
    """Return the cost of a piece for a robot that starts free; infinite in a collision."""
    reach = max((math.hypot(*corner) for corner in corners), default=0.0)
    row, column = math.floor(start[1]), math.floor(start[0])
    passed = list(points(start, *piece, reach))
    total = 0.0
    for pose in passed:
        before = row, column
        row, column = math.floor(pose[1]), math.floor(pose[0])
        diagonal = row != before[0] and column != before[1]
        for r, c in ((row, column), (before[0], column), (row, before[1])) if diagonal else ((row, column),):
            if not (0 <= r < costs.shape[0] and 0 <= c < costs.shape[1]) or costs[r, c] >= 253:
                return math.inf
        if corners and not outline_is_free(costs == 254, placed(corners, pose), outside):
            return math.inf
        total += rates[costs[row, column]]
    return total * abs(piece[1]) / len(passed)
