"""Twin of the laser: follows each beam in small steps to a wall or a disc."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED_THRESHOLD, GridMap


def measure(
    grid: GridMap,
    pose: Pose2D,
    angles: NDArray[np.float64],
    discs: list[tuple[float, float, float]],
    range_max: float,
    step: float = 0.002,
) -> NDArray[np.float64]:
    """Return the ranges to walls and to discs (x, y, radius), to within a step; infinite without a hit."""
    ranges = np.full(len(angles), np.inf)
    for beam, angle in enumerate(angles):
        distance = 0.0
        while distance <= range_max:
            x = pose.x + distance * math.cos(pose.theta + angle)
            y = pose.y + distance * math.sin(pose.theta + angle)
            cell = grid.info.cell_of(x, y)
            in_wall = cell is not None and grid.data[cell] >= OCCUPIED_THRESHOLD
            if in_wall or any(math.hypot(x - cx, y - cy) <= radius for cx, cy, radius in discs):
                ranges[beam] = distance
                break
            distance += step
    return ranges
