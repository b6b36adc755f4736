"""Kernels: mean and covariance of the heaviest cluster of particles."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.kernel_cache.decorators import compiled
from ppaas.localization.kernels.bins import bin_of, empty_table, slot_of


@compiled
def _turned(angle: float) -> float:
    """Return an angle in [−π, π)."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@compiled
def heaviest_bin(particles: NDArray[np.float64], weights: NDArray[np.float64]) -> int:
    """Return the index of a particle in the bin with the largest total weight.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
        Weights of the particles.
    """
    table = empty_table(particles.shape[0])
    sums = np.zeros(table.size)
    members = np.zeros(table.size, np.int64)
    best = 0
    for i in range(particles.shape[0]):
        key = bin_of(particles[i, 0], particles[i, 1], particles[i, 2])
        slot = slot_of(table, key)
        if table[slot] != key:
            table[slot] = key
            members[slot] = i
        sums[slot] += weights[i]
        if i == 0 or sums[slot] > sums[best]:
            best = slot
    found: int = members[best]
    return found


@compiled
def moments_around(
    particles: NDArray[np.float64], weights: NDArray[np.float64], pose: Pose2D, radius: float, turn: float
) -> tuple[float, tuple[float, float, float], NDArray[np.float64]]:
    """Return weight, mean and covariance of the particles within ``radius`` and ``turn`` of a pose.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
        Weights of the particles.
    pose : Pose2D
        Centre of the cluster: x, y [m], theta [rad].
    radius, turn : float
        Largest distance and angle from the centre [m, rad].

    Returns
    -------
    float
        Sum of the weights.
    (x, y, theta)
        Weighted mean, or the centre if the sum is 0. Angles are averaged by their difference from the centre's.
    (3, 3) array
        Weighted covariance around the mean.
    """
    # First and second moments of the differences to the centre, upper triangle only.
    total = 0.0
    first, second = np.zeros(3), np.zeros((3, 3))
    for i in range(particles.shape[0]):
        dx, dy = particles[i, 0] - pose[0], particles[i, 1] - pose[1]
        if dx * dx + dy * dy >= radius * radius:
            continue
        dt = _turned(particles[i, 2] - pose[2])
        if abs(dt) >= turn:
            continue
        weight = weights[i]
        total += weight
        first[0] += weight * dx
        first[1] += weight * dy
        first[2] += weight * dt
        second[0, 0] += weight * dx * dx
        second[0, 1] += weight * dx * dy
        second[0, 2] += weight * dx * dt
        second[1, 1] += weight * dy * dy
        second[1, 2] += weight * dy * dt
        second[2, 2] += weight * dt * dt
    if total <= 0.0:
        return 0.0, (pose[0], pose[1], pose[2]), second
    # Covariance = E[d dᵀ] − E[d] E[d]ᵀ.
    first /= total
    for r in range(3):
        for c in range(r, 3):
            second[r, c] = second[c, r] = second[r, c] / total - first[r] * first[c]
    return total, (pose[0] + first[0], pose[1] + first[1], _turned(pose[2] + first[2])), second


def warm() -> None:
    """Call each kernel once, so that it is compiled or loaded from the cache."""
    heaviest_bin(np.zeros((1, 3)), np.ones(1))
    moments_around(np.zeros((1, 3)), np.ones(1), Pose2D(0.0, 0.0, 0.0), 1.0, 1.0)
