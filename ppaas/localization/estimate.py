"""From weighted particles to one pose."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.kernels.cluster import mean_around

BIN_SIZE = (0.5, 0.5, math.radians(10.0))
"""Bins of the histogram over poses [m, m, rad], as in amcl's ``pf_kdtree.c``."""

_CLUSTER_RADIUS = 0.75
_CLUSTER_TURN = math.radians(45.0)
_SHIFTS = 3


@dataclass(frozen=True, slots=True)
class PoseEstimate:
    """A pose and how sure it is.

    Parameters
    ----------
    pose : Pose2D
        In the map frame.
    covariance : (3, 3) array
        Of x [m], y [m], theta [rad].
    """

    pose: Pose2D
    covariance: NDArray[np.float64]


def bins_of(particles: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the bin of each particle as one integer, (n,) from (n, 3)."""
    cells = np.floor(particles / BIN_SIZE).astype(np.int64)
    return (cells[:, 0] << 40) ^ ((cells[:, 1] & 0xFFFFF) << 16) ^ (cells[:, 2] & 0xFFFF)


def estimate(particles: NDArray[np.float64], weights: NDArray[np.float64]) -> PoseEstimate:
    """Return mean and covariance of the heaviest cluster.

    The cluster is found by mean shift from the heaviest bin, so a second cluster elsewhere does not draw the mean
    into a wall between the two.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
        Sum 1.
    """
    bins, inverse = np.unique(bins_of(particles), return_inverse=True)
    heaviest = np.argmax(np.bincount(inverse, weights, len(bins)))
    chosen = inverse == heaviest
    mean = _mean(particles[chosen], weights[chosen])
    for _ in range(_SHIFTS):
        middle = mean
        x, y, theta = mean_around(particles, weights, middle, _CLUSTER_RADIUS, _CLUSTER_TURN)
        mean = Pose2D(x, y, wrap_angle(theta))
    apart = particles - middle
    chosen = (np.hypot(apart[:, 0], apart[:, 1]) < _CLUSTER_RADIUS) & (np.abs(_wrapped(apart[:, 2])) < _CLUSTER_TURN)
    return PoseEstimate(mean, _covariance(particles[chosen], weights[chosen], mean))


def _wrapped(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    wrapped: NDArray[np.float64] = (angles + np.pi) % (2.0 * np.pi) - np.pi
    return wrapped


def _mean(particles: NDArray[np.float64], weights: NDArray[np.float64]) -> Pose2D:
    x, y = np.average(particles[:, :2], axis=0, weights=weights)
    turn = math.atan2(weights @ np.sin(particles[:, 2]), weights @ np.cos(particles[:, 2]))
    return Pose2D(float(x), float(y), wrap_angle(turn))


def _covariance(particles: NDArray[np.float64], weights: NDArray[np.float64], mean: Pose2D) -> NDArray[np.float64]:
    apart = particles - mean
    apart[:, 2] = _wrapped(apart[:, 2])
    share = weights / weights.sum()
    covariance: NDArray[np.float64] = (apart * share[:, None]).T @ apart
    return covariance
