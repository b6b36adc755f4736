"""Kernel: costs of costmap_2d's inflation layer from distances to obstacles."""

import math
from collections.abc import Callable

import numpy as np
from numba import prange, types
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION
from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.serial import serial_copy

_DISTANCES = types.Array(types.float32, 2, "C", readonly=True)
_MASK = types.Array(types.uint8, 2, "C", readonly=True)
_SLACK = 1e-5
"""Tolerance for float32 rounding, so that a distance equal to a radius counts as within it [m]."""

_SIGNATURE = types.uint8[:, ::1](_DISTANCES, _MASK, types.float64, types.float64, types.float64)


def _inflate(
    distance: NDArray[np.float32], unknown: NDArray[np.uint8], inscribed: float, inflation: float, scaling: float
) -> NDArray[np.uint8]:
    """Return the cost of each cell, as in ``ppaas.costmap.inflation_layer.inflate``."""
    height, width = distance.shape
    costs = np.empty((height, width), np.uint8)
    for r in prange(height):
        for c in range(width):
            d = distance[r, c]
            if d == 0.0:
                costs[r, c] = LETHAL_OBSTACLE
            elif d <= inscribed + _SLACK:
                costs[r, c] = INSCRIBED_INFLATED_OBSTACLE
            elif unknown[r, c]:
                costs[r, c] = NO_INFORMATION
            elif d <= inflation + _SLACK:
                decay = math.exp(-scaling * (d - inscribed))
                costs[r, c] = int((INSCRIBED_INFLATED_OBSTACLE - 1) * decay)
            else:
                costs[r, c] = 0
    return costs


Inflate = Callable[[NDArray[np.float32], NDArray[np.uint8], float, float, float], NDArray[np.uint8]]
"""(h, w) distances [m], (h, w) unknown cells (not 0), inscribed and inflation radius [m], decay [1/m] → costs."""

inflate_parallel: Inflate = compiled(_SIGNATURE, parallel=True)(_inflate)
inflate_serial: Inflate = compiled(_SIGNATURE)(serial_copy(_inflate))


def warm() -> None:
    """Call each kernel once."""
    distance, unknown = np.ones((2, 2), np.float32), np.zeros((2, 2), np.uint8)
    inflate_parallel(distance, unknown, 0.18, 0.55, 10.0)
    inflate_serial(distance, unknown, 0.18, 0.55, 10.0)
