"""Slow, obvious twin of the social layer: each cell by angle and distance, as in social_navigation_layers."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.social_layer import Proxemics


def raised(
    costs: NDArray[np.uint8], people: list[tuple[float, float, float, float]], resolution: float, how: Proxemics
) -> NDArray[np.uint8]:
    """Return the costs with people: x, y [m] from the corner of cell (0, 0), and velocities [m/s]."""
    result = costs.copy()
    for row, column in np.ndindex(costs.shape):
        if costs[row, column] == 255:
            continue
        for x, y, vx, vy in people:
            dx, dy = (column + 0.5) * resolution - x, (row + 0.5) * resolution - y
            off = math.remainder(math.atan2(dy, dx) - math.atan2(vy, vx), 2.0 * math.pi)
            in_front = abs(off) < math.pi / 2
            stretched = how.covariance * (1.0 + how.factor * math.hypot(vx, vy)) if in_front else how.covariance
            along, aside = math.cos(off) * math.hypot(dx, dy), math.sin(off) * math.hypot(dx, dy)
            cost = how.amplitude * math.exp(-(along**2 / (2 * stretched) + aside**2 / (2 * how.covariance)))
            if cost >= how.cutoff:
                result[row, column] = max(result[row, column], math.floor(cost))
    return result
