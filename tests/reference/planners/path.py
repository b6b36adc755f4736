"""Slow, obvious twins of a path's poses and cost, of its smoothing, and of its text."""

import itertools
import math
from collections.abc import Sequence

from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D, quaternion_of


def slow_poses(costmap: Costmap, cells: list[tuple[int, int]], start: Pose2D, goal: Pose2D) -> list[tuple[float, ...]]:
    """Return the poses of a path through the centres of cells."""
    places = [tuple(costmap.info.to_world(cell).tolist()) for cell in cells]
    places[0] = start.x, start.y
    places[-1] = goal.x, goal.y
    poses = []
    for at, place in enumerate(places):
        yaw = start.theta
        if at == len(places) - 1:
            yaw = goal.theta
        elif at > 0:
            ahead = places[at + 1]
            yaw = math.atan2(ahead[1] - place[1], ahead[0] - place[0])
        poses.append((*place, 0.0, *quaternion_of(yaw)))
    return poses


def slow_cost(costmap: Costmap, cells: list[tuple[int, int]]) -> float:
    """Return the cost of the moves of a path."""
    return math.fsum(
        (50.0 + 0.8 * float(costmap.data[here])) * math.dist(here, there) for here, there in itertools.pairwise(cells)
    )


def number_text(value: float) -> str:
    """Return a number rounded to nine decimals, without trailing zeros but with at least one decimal."""
    billionths = round(abs(value) * 10**9)
    sign = "-" if value < 0.0 and billionths else ""
    whole, rest = divmod(billionths, 10**9)
    decimals = f"{rest:09d}".rstrip("0") or "0"
    return f"{sign}{whole}.{decimals}"


def rows_text(rows: Sequence[Sequence[float]], pieces: Sequence[str]) -> str:
    """Return all rows, each as piece, number, piece, …, number, piece."""
    *before, last = pieces
    return "".join(
        "".join(piece + number_text(value) for piece, value in zip(before, row, strict=True)) + last for row in rows
    )


Points = list[list[float]]


def relax(points: Points, near: list[float], even: float, rounds: int) -> Points:
    """Return the converged points x, y; those with an infinite data weight are fixed."""
    found = [list(point) for point in points]
    for _ in range(rounds):
        for at in range(1, len(points) - 1):
            if math.isinf(near[at]):
                continue
            for axis in range(2):
                pull = near[at] * (points[at][axis] - found[at][axis])
                pull += even * (found[at - 1][axis] + found[at + 1][axis] - 2.0 * found[at][axis])
                found[at][axis] += pull / (near[at] + 2.0 * even)
    return found
