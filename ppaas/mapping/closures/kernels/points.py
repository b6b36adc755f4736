"""Kernels: points of many scans in one frame, and one point per cell."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled


@compiled
def gather(
    points: NDArray[np.float32], valid: NDArray[np.bool_], poses: NDArray[np.float64], frame: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the valid points of scans in a common frame.

    Parameters
    ----------
    points : (k, b, 2) float32 array
        Points of each scan in the frame of its laser [m].
    valid : (k, b) bool array
        Points that were measured.
    poses : (k, 3) array
        Poses of the laser: x, y [m], theta [rad].
    frame : (3,) array
        Pose of the common frame, in the frame of ``poses``.

    Returns
    -------
    (n, 2) array
        Points in the common frame [m], scan by scan.
    """
    out = np.empty((points.shape[0] * points.shape[1], 2))
    c0, s0 = math.cos(frame[2]), math.sin(frame[2])
    n = 0
    for k in range(points.shape[0]):
        # Pose of the scan in the common frame.
        dx, dy = poses[k, 0] - frame[0], poses[k, 1] - frame[1]
        x0, y0 = c0 * dx + s0 * dy, c0 * dy - s0 * dx
        c, s = math.cos(poses[k, 2] - frame[2]), math.sin(poses[k, 2] - frame[2])
        for b in range(points.shape[1]):
            if valid[k, b]:
                px, py = points[k, b, 0], points[k, b, 1]
                out[n, 0] = x0 + c * px - s * py
                out[n, 1] = y0 + s * px + c * py
                n += 1
    return out[:n].copy()


@compiled
def thin(points: NDArray[np.float64], size: float, reach: float) -> NDArray[np.float64]:
    """Return the mean of the points of each cell of a square around the origin.

    Parameters
    ----------
    points : (n, 2) array
        Points [m].
    size : float
        Edge of a cell [m].
    reach : float
        Half the edge of the square [m]; points beyond are left out.

    Returns
    -------
    (m, 2) array
        One point per cell that has points [m], row by row.
    """
    n = math.ceil(2.0 * reach / size)
    # Sums of x, y and 1 of each cell.
    sums = np.zeros((n * n, 3))
    for i in range(points.shape[0]):
        u = math.floor((points[i, 0] + reach) / size)
        v = math.floor((points[i, 1] + reach) / size)
        if 0 <= u < n and 0 <= v < n:
            sums[v * n + u, 0] += points[i, 0]
            sums[v * n + u, 1] += points[i, 1]
            sums[v * n + u, 2] += 1.0
    out = np.empty((min(points.shape[0], n * n), 2))
    m = 0
    for cell in range(n * n):
        if sums[cell, 2] > 0.0:
            out[m, 0], out[m, 1] = sums[cell, 0] / sums[cell, 2], sums[cell, 1] / sums[cell, 2]
            m += 1
    return out[:m].copy()


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    points, valid, poses = np.zeros((1, 1, 2), np.float32), np.ones((1, 1), np.bool_), np.zeros((1, 3))
    poses.flags.writeable = False  # as those of a pose graph
    thin(gather(points, valid, poses, np.zeros(3)), 1.0, 1.0)
