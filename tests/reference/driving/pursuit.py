"""Twins of pure pursuit's carrot and arcs."""

import itertools
import math

import numpy as np
from numpy.typing import NDArray


def carrot(points: NDArray[np.float64], robot: tuple[float, float], distance: float) -> tuple[float, float]:
    """Return the first point of a path, sampled every millimetre, at a distance from the robot; otherwise the last.

    The segment between two points within the circle stays within it.
    """
    if math.dist(points[0], robot) >= distance:
        return float(points[0][0]), float(points[0][1])
    for a, b in itertools.pairwise(points):
        for part in np.linspace(0.0, 1.0, max(2, math.ceil(math.dist(a, b) / 0.001))):
            point = a + part * (b - a)
            if math.dist(point, robot) >= distance:
                return float(point[0]), float(point[1])
    return float(points[-1][0]), float(points[-1][1])


def arc(start: tuple[float, float, float], length: float, turn: float, count: int) -> list[tuple[float, float, float]]:
    """Return ``count + 1`` poses along an arc, the first and the last included."""
    x, y, theta = start
    poses = []
    for part in np.linspace(0.0, 1.0, count + 1).tolist():
        if abs(turn) < 1e-9:
            poses.append((x + part * length * math.cos(theta), y + part * length * math.sin(theta), theta))
            continue
        radius, heading = length / turn, theta + part * turn
        poses.append((
            x + radius * (math.sin(heading) - math.sin(theta)),
            y - radius * (math.cos(heading) - math.cos(theta)),
            heading,
        ))  # fmt: skip
    return poses
