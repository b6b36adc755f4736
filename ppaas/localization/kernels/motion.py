"""Moving particles by odometry."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

HALF_TURN = math.pi


@njit(cache=True, nogil=True, error_model="numpy")
def _wrap(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@njit(cache=True, nogil=True, error_model="numpy")
def _smaller_turn(angle: float) -> float:
    """Return how far a turn is from going straight ahead or straight back, so that reversing is no half turn."""
    return min(abs(_wrap(angle)), abs(_wrap(angle - HALF_TURN)))


@njit(cache=True, nogil=True, error_model="numpy")
def sample_motion(
    particles: NDArray[np.float64],
    first_turn: float,
    distance: float,
    second_turn: float,
    alphas: NDArray[np.float64],
    normals: NDArray[np.float64],
) -> None:
    """Move particles, in place, by turn, straight line and turn, each with noise.

    The odometry motion model of Thrun, Burgard, Fox, *Probabilistic Robotics*, table 5.6, as amcl's ``diff``.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    first_turn, distance, second_turn : float
        What odometry measured [rad, m, rad].
    alphas : (4,) array
        Noise: turn from turn, turn from distance, distance from distance, distance from turn.
    normals : (n, 3) array
        Standard normal random numbers.
    """
    first = _smaller_turn(first_turn)
    second = _smaller_turn(second_turn)
    sigma_first = math.sqrt(alphas[0] * first * first + alphas[1] * distance * distance)
    sigma_second = math.sqrt(alphas[0] * second * second + alphas[1] * distance * distance)
    sigma_distance = math.sqrt(alphas[2] * distance * distance + alphas[3] * (first * first + second * second))
    for i in range(particles.shape[0]):
        heading = particles[i, 2] + first_turn + sigma_first * normals[i, 0]
        step = distance + sigma_distance * normals[i, 1]
        particles[i, 0] += step * math.cos(heading)
        particles[i, 1] += step * math.sin(heading)
        particles[i, 2] = _wrap(heading + second_turn + sigma_second * normals[i, 2])


def warm() -> None:
    """Compile, or load what was compiled."""
    sample_motion(np.zeros((1, 3)), 0.0, 0.0, 0.0, np.zeros(4), np.zeros((1, 3)))
