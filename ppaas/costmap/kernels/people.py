"""Kernel: costs near people, as in the proxemic layer of social_navigation_layers."""

import math

import numpy as np
from numba import types
from numpy.typing import NDArray

from ppaas.cost_values import NO_INFORMATION
from ppaas.kernel_cache.decorators import compiled

_CELLS = types.uint8[:, ::1]
_PEOPLE = types.Array(types.float64, 2, "C", readonly=True)
_FLOAT = types.float64


@compiled(types.int64(_CELLS, _PEOPLE, _FLOAT, _FLOAT, _FLOAT, _FLOAT, _FLOAT))
def raise_around(
    costs: NDArray[np.uint8],
    people: NDArray[np.float64],
    resolution: float,
    amplitude: float,
    covariance: float,
    cutoff: float,
    factor: float,
) -> int:
    """Raise the costs around people to a Gaussian, which is stretched in the direction in which a person walks.

    Only the bounding box of the raised cells is visited. Unknown cells stay unknown, and no cost is lowered.

    Parameters
    ----------
    costs : (h, w) uint8 array
        Modified: values of costmap_2d.
    people : (n, 4) array
        Position x, y from the corner of cell (0, 0) [m] and velocity [m/s], along the axes of the grid.
    resolution : float
        Edge of a cell [m].
    amplitude : float
        Cost at the position of a person.
    covariance : float
        Variance of the Gaussian [m²].
    cutoff : float
        Least cost that is applied.
    factor : float
        Growth of the covariance in front of a person, relative to itself and per speed [s/m].

    Returns
    -------
    int
        Number of raised cells.
    """
    height, width = costs.shape
    raised = 0
    if cutoff >= amplitude:
        return raised
    for i in range(len(people)):
        x, y, speed = people[i, 0], people[i, 1], math.hypot(people[i, 2], people[i, 3])
        cosine, sine = (people[i, 2] / speed, people[i, 3] / speed) if speed > 0.0 else (1.0, 0.0)
        ahead = covariance * (1.0 + speed * factor)
        # Bounding box: the Gaussian falls to the cutoff on half an ellipse in front of the person, and on half a circle
        # behind. ``across`` and ``up`` are the half extents of the ellipse along x and y, ``base`` the circle's radius.
        decay = 2.0 * math.log(amplitude / cutoff)
        base = math.sqrt(decay * covariance)
        across = math.sqrt(decay * (ahead * cosine * cosine + covariance * sine * sine))
        up = math.sqrt(decay * (ahead * sine * sine + covariance * cosine * cosine))
        left, right = (across if cosine < 0.0 else base), (across if cosine > 0.0 else base)
        below, above = (up if sine < 0.0 else base), (up if sine > 0.0 else base)
        # Clip before the conversion to integers, since a person may be arbitrarily far away.
        first_row = int(min(max((y - below) / resolution, 0.0), float(height)))
        last_row = int(min(max((y + above) / resolution + 1.0, 0.0), float(height)))
        first_column = int(min(max((x - left) / resolution, 0.0), float(width)))
        last_column = int(min(max((x + right) / resolution + 1.0, 0.0), float(width)))
        for row in range(first_row, last_row):
            for column in range(first_column, last_column):
                dx, dy = (column + 0.5) * resolution - x, (row + 0.5) * resolution - y
                along, aside = cosine * dx + sine * dy, cosine * dy - sine * dx
                spread = ahead if along > 0.0 else covariance
                cost = amplitude * math.exp(-0.5 * (along * along / spread + aside * aside / covariance))
                before = costs[row, column]
                if cost >= cutoff and before != NO_INFORMATION and cost >= before + 1.0:
                    costs[row, column] = np.uint8(cost)
                    raised += 1
    return raised


def warm() -> None:
    """Call the kernel once."""
    raise_around(np.zeros((2, 2), np.uint8), np.zeros((1, 4)), 0.05, 77.0, 0.25, 10.0, 5.0)
