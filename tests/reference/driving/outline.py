"""Twins of the collision checks of a robot's outline."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

Floats = NDArray[np.float64]


def bilinear(field: NDArray[np.float32], x: float, y: float, edge: float) -> float:
    """Return a value interpolated between the centres of cells; outside, that of the nearest edge."""
    at = np.array([[y / edge - 0.5], [x / edge - 0.5]])
    return float(map_coordinates(field.astype(np.float64), at, order=1, mode="nearest")[0])


def outline_distance(
    lethal: NDArray[np.bool_], edge: float, corners: Floats, pose: tuple[float, float, float]
) -> float:
    """Return the distance of an outline to the centre of the nearest lethal cell, measured every millimetre."""
    placed = _placed(corners, pose)
    points = []
    for a, b in zip(placed, np.roll(placed, -1, axis=0), strict=True):
        count = max(2, round(float(np.hypot(*(b - a))) / 0.001))
        points.append(a + np.linspace(0.0, 1.0, count)[:, None] * (b - a))
    outline = np.concatenate(points)
    return float(min(np.hypot(*(outline - middle).T).min() for middle in _middles(lethal, edge)))


def outline_holds(lethal: NDArray[np.bool_], edge: float, corners: Floats, pose: tuple[float, float, float]) -> bool:
    """Return whether the centre of a lethal cell is in a convex outline with counterclockwise corners."""
    placed = _placed(corners, pose)
    sides = np.roll(placed, -1, axis=0) - placed
    return any(
        all(
            side[0] * (middle - corner)[1] >= side[1] * (middle - corner)[0]
            for corner, side in zip(placed, sides, strict=True)
        )
        for middle in _middles(lethal, edge)
    )


def _placed(corners: Floats, pose: tuple[float, float, float]) -> Floats:
    x, y, theta = pose
    rotation = np.array(((math.cos(theta), -math.sin(theta)), (math.sin(theta), math.cos(theta))))
    return corners @ rotation.T + (x, y)


def _middles(lethal: NDArray[np.bool_], edge: float) -> Floats:
    return (np.argwhere(lethal)[:, ::-1] + 0.5) * edge
