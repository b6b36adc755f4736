"""Nearest poses by position and heading."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.kernels import neighbours as kernels
from ppaas.planar_poses import PoseArray

MOST_BUCKETS = 1 << 20
"""Largest number of buckets that poses are sorted into; poses far apart get larger ones."""


def nearest_poses(queries: PoseArray, poses: PoseArray, count: int, radius: float) -> NDArray[np.int64]:
    """Return the nearest poses of each query; a turn counts as metres: 1 rad as about 1 m, half a turn as 2 m.

    Parameters
    ----------
    queries : (q, 3) array
        x, y [m], theta [rad].
    poses : (n, 3) array
        Poses to choose from.
    count : int
        Largest number of poses of each query.
    radius : float
        Largest distance [m].

    Returns
    -------
    (q, count) int64 array
        Indices of poses, nearest first; −1 where there are no more.
    """
    width, height = np.ptp(poses[:, :2], axis=0) if len(poses) else (0.0, 0.0)
    edge = max(radius, float(np.sqrt(width * height / MOST_BUCKETS)), float(max(width, height)) / MOST_BUCKETS * 2.0)
    found: NDArray[np.int64] = kernels.nearest(queries, poses, count, radius, edge)
    return found
