"""Kernel: distances from points to the nearest wall."""

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray


def cast(walls: NDArray[np.float64], origins: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance from each origin (b, 2) to the nearest wall (n, 4) in a direction (b,) [m].

    It is infinite where there is no wall.
    """
    distances: NDArray[np.float64] = _cast(walls, origins, angles)
    return distances


@njit(cache=True, nogil=True, error_model="numpy")
def _cast(walls: Any, origins: Any, angles: Any) -> Any:
    """With × for the cross product, the ray is o + r d and the wall a + t e.

    So r = (a − o) × e / d × e and t = (a − o) × d / d × e. A ray along a wall gives NaN or infinity, and hits nothing.
    """
    distances = np.full(len(origins), np.inf)
    for beam in range(len(origins)):
        x, y = origins[beam, 0], origins[beam, 1]
        c, s = math.cos(angles[beam]), math.sin(angles[beam])
        nearest = np.inf
        for wall in range(len(walls)):
            a, b = walls[wall, 0] - x, walls[wall, 1] - y
            e, f = walls[wall, 2] - walls[wall, 0], walls[wall, 3] - walls[wall, 1]
            per = 1.0 / (c * f - s * e)
            distance = (a * f - b * e) * per
            place = (a * s - b * c) * per
            if 0.0 < distance < nearest and 0.0 <= place <= 1.0:
                nearest = distance
        distances[beam] = nearest
    return distances
