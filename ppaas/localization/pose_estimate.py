"""Pose estimate: the heaviest cluster of weighted particles."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.localization.kernels.cluster import heaviest_bin, moments_around

_CLUSTER_RADIUS = 0.75
_CLUSTER_TURN = math.radians(45.0)
"""Size of a cluster around its mean [m, rad]."""

_SHIFTS = 3
"""Iterations of mean shift."""


@dataclass(frozen=True, slots=True)
class PoseEstimate:
    """Estimated pose and its uncertainty.

    Parameters
    ----------
    pose : Pose2D
        In the map frame.
    covariance : (3, 3) array
        Covariance of x [m], y [m], theta [rad].
    share : float
        Part of the total weight that is near this pose; the remaining particles are elsewhere.
    """

    pose: Pose2D
    covariance: NDArray[np.float64]
    share: float = 1.0


def estimate(particles: NDArray[np.float64], weights: NDArray[np.float64]) -> PoseEstimate:
    """Return mean and covariance of the heaviest cluster.

    The cluster is found by mean shift from the heaviest bin, so a second cluster elsewhere does not pull the mean
    into a wall between the two.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
        Weights with sum 1.
    """
    pose = Pose2D(*particles[heaviest_bin(particles, weights)].tolist())
    for _ in range(_SHIFTS):
        share, mean, covariance = moments_around(particles, weights, pose, _CLUSTER_RADIUS, _CLUSTER_TURN)
        pose = Pose2D(*mean)
    return PoseEstimate(pose, covariance, share)


def weight_around(particles: NDArray[np.float64], weights: NDArray[np.float64], pose: Pose2D) -> float:
    """Return the total weight of the particles within a cluster's size of a pose.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
    pose : Pose2D
    """
    return moments_around(particles, weights, pose, _CLUSTER_RADIUS, _CLUSTER_TURN)[0]
