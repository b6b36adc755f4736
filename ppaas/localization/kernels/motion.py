"""Kernels: motion of particles by odometry with noise."""

import math
from collections.abc import Callable

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.serial import serial_copy

Motion = tuple[float, float, float]
Move = Callable[[NDArray[np.float64], Motion, Motion, NDArray[np.float64]], None]


@compiled
def _wrap(angle: float) -> float:
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def _move_diff(particles: NDArray[np.float64], motion: Motion, sigmas: Motion, normals: NDArray[np.float64]) -> None:
    """Move particles in place by a turn, a straight line and a turn, each with noise.

    Thrun, Burgard, Fox, *Probabilistic Robotics*, table 5.6.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad]; modified.
    motion : (first turn, distance, second turn)
        Motion measured by odometry [rad, m, rad].
    sigmas : (float, float, float)
        Standard deviations of its three components.
    normals : (n, 3) array
        Standard normal random numbers.
    """
    for i in prange(particles.shape[0]):
        heading = particles[i, 2] + motion[0] + sigmas[0] * normals[i, 0]
        step = motion[1] + sigmas[1] * normals[i, 1]
        particles[i, 0] += step * math.cos(heading)
        particles[i, 1] += step * math.sin(heading)
        particles[i, 2] = _wrap(heading + motion[2] + sigmas[2] * normals[i, 2])


def _move_omni(particles: NDArray[np.float64], motion: Motion, sigmas: Motion, normals: NDArray[np.float64]) -> None:
    """Move particles in place along a bearing, with noise along it, across it and of the turn (``amcl_odom.cpp``).

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad]; modified.
    motion : (bearing, distance, turn)
        Motion measured by odometry; the bearing is relative to the robot's heading [rad, m, rad].
    sigmas : (float, float, float)
        Standard deviations along the bearing, across it, and of the turn [m, m, rad].
    normals : (n, 3) array
        Standard normal random numbers.
    """
    for i in prange(particles.shape[0]):
        bearing = particles[i, 2] + motion[0]
        c, s = math.cos(bearing), math.sin(bearing)
        step, aside = motion[1] + sigmas[0] * normals[i, 0], sigmas[1] * normals[i, 1]
        particles[i, 0] += step * c + aside * s
        particles[i, 1] += step * s - aside * c
        particles[i, 2] = _wrap(particles[i, 2] + motion[2] + sigmas[2] * normals[i, 2])


move_diff_parallel: Move = compiled(parallel=True)(_move_diff)
move_diff_serial: Move = compiled(serial_copy(_move_diff))
move_omni_parallel: Move = compiled(parallel=True)(_move_omni)
move_omni_serial: Move = compiled(serial_copy(_move_omni))


def warm() -> None:
    """Call each kernel once, so that it is compiled or loaded from the cache."""
    for move in (move_diff_serial, move_diff_parallel, move_omni_serial, move_omni_parallel):
        move(np.zeros((1, 3)), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), np.zeros((1, 3)))
