"""Arithmetic on arrays of poses in the plane: (…, 3) arrays of x, y [m], theta [rad]; beside `geometry.Pose2D`."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D

PoseArray = NDArray[np.float64]
"""(…, 3) array: x, y [m], theta [rad]."""


def wrap_angles(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Wrap angles [rad] to [−π, π)."""
    wrapped: NDArray[np.float64] = (angles + math.pi) % (2.0 * math.pi) - math.pi
    return wrapped


def compose(poses: PoseArray, others: PoseArray) -> PoseArray:
    """Transform ``others`` from the frames at ``poses`` into the frame that ``poses`` are in; arrays broadcast."""
    poses, others = np.broadcast_arrays(poses, others)
    c, s = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    composed = np.empty(poses.shape)
    composed[..., 0] = poses[..., 0] + c * others[..., 0] - s * others[..., 1]
    composed[..., 1] = poses[..., 1] + s * others[..., 0] + c * others[..., 1]
    composed[..., 2] = wrap_angles(poses[..., 2] + others[..., 2])
    return composed


def relative(poses: PoseArray, others: PoseArray) -> PoseArray:
    """Return ``others`` in the frames at ``poses``, both given in one frame; arrays broadcast."""
    poses, others = np.broadcast_arrays(poses, others)
    c, s = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    x, y = others[..., 0] - poses[..., 0], others[..., 1] - poses[..., 1]
    turn = wrap_angles(others[..., 2] - poses[..., 2])
    return np.stack((c * x + s * y, c * y - s * x, turn), axis=-1)


def differences(poses: PoseArray, others: PoseArray) -> PoseArray:
    """Return ``poses`` − ``others``, number by number, with wrapped headings."""
    result = poses - others
    result[..., 2] = wrap_angles(result[..., 2])
    return result


def inverse(poses: PoseArray) -> PoseArray:
    """Return the inverse poses: ``compose(p, inverse(p))`` is the identity."""
    return relative(poses, np.zeros(3))


def moved_points(motion: Pose2D, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (n, 2) in the frame of a pose, x, y [m], in the frame that the pose is in."""
    cos, sin = np.cos(motion.theta), np.sin(motion.theta)
    moved: NDArray[np.float64] = points @ np.array(((cos, sin), (-sin, cos))) + np.array((motion.x, motion.y))
    return moved


def symmetric(upper: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (…, 3, 3) matrices of their upper triangles (…, 6): xx, xy, xt, yy, yt, tt."""
    full: NDArray[np.float64] = upper[..., [[0, 1, 2], [1, 3, 4], [2, 4, 5]]]
    return full


def upper_triangle(matrices: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the upper triangles (…, 6): xx, xy, xt, yy, yt, tt of (…, 3, 3) matrices."""
    upper: NDArray[np.float64] = matrices[..., [0, 0, 0, 1, 1, 2], [0, 1, 2, 1, 2, 2]]
    return upper


def rotated(matrices: NDArray[np.float64], angles: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Rotate information or covariance matrices into another frame.

    Parameters
    ----------
    matrices : (…, 3, 3) array
        Matrices of x, y, theta in a frame.
    angles : (…) array
        Headings of that frame in the frame of the result [rad].

    Returns
    -------
    (…, 3, 3) array
    """
    angles = np.asarray(angles)
    turn = np.zeros((*angles.shape, 3, 3))
    turn[..., 0, 0] = turn[..., 1, 1] = np.cos(angles)
    turn[..., 1, 0] = np.sin(angles)
    turn[..., 0, 1] = -turn[..., 1, 0]
    turn[..., 2, 2] = 1.0
    return turn @ matrices @ np.swapaxes(turn, -1, -2)
