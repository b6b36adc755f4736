"""The mean of the particles around a pose."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.geometry import Pose2D


@njit(cache=True, nogil=True, error_model="numpy")
def mean_around(
    particles: NDArray[np.float64],
    weights: NDArray[np.float64],
    pose: Pose2D,
    radius: float,
    turn: float,
) -> tuple[float, float, float]:
    """Return the weighted mean of the particles nearer to a pose than ``radius`` and ``turn``.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
        At least one that is near has a weight above 0.
    pose : Pose2D
        x, y [m], theta [rad].
    radius, turn : float
        How far off a particle may be [m, rad].
    """
    x, y, theta = pose
    total = sum_x = sum_y = sum_cos = sum_sin = 0.0
    for i in range(particles.shape[0]):
        dx, dy = particles[i, 0] - x, particles[i, 1] - y
        if dx * dx + dy * dy >= radius * radius:
            continue
        off = particles[i, 2] - theta
        off -= 2.0 * math.pi * math.floor(off / (2.0 * math.pi) + 0.5)
        if abs(off) >= turn:
            continue
        weight = weights[i]
        total += weight
        sum_x += weight * dx
        sum_y += weight * dy
        sum_cos += weight * math.cos(off)
        sum_sin += weight * math.sin(off)
    return x + sum_x / total, y + sum_y / total, theta + math.atan2(sum_sin, sum_cos)


def warm() -> None:
    """Compile, or load what was compiled."""
    mean_around(np.zeros((1, 3)), np.ones(1), Pose2D(0.0, 0.0, 0.0), 1.0, 1.0)
