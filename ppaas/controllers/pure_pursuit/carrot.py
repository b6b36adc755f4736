"""Carrot: the point of a path that the robot steers towards; and the legs of a path that reverses direction."""

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, Poses

Floats = NDArray[np.float64]

STANDING = 1e-6
"""Distance below which two poses are at the same position [m]."""


def carrot_at(points: Floats, pose: Pose2D, distance: float) -> Pose2D:
    """Return the point where a path first leaves a circle around the robot, in the robot's frame.

    Parameters
    ----------
    points : (m, 2) array
        Path from the robot on [m]; at least one point.
    pose : Pose2D
        Pose of the robot.
    distance : float
        Radius of the circle [m].

    Returns
    -------
    Pose2D
        The first point of the path if all are outside, the last if all are inside. Its heading has no meaning.
    """
    offsets = points - (pose.x, pose.y)
    outside = np.hypot(offsets[:, 0], offsets[:, 1]) >= distance
    last = int(np.argmax(outside)) if outside.any() else len(points) - 1
    x, y = points[last].tolist()
    if last > 0 and outside[last]:
        inner, step = offsets[last - 1], offsets[last] - offsets[last - 1]
        a, b, c = float(step @ step), float(inner @ step), float(inner @ inner) - distance * distance
        part = (-b + math.sqrt(max(b * b - a * c, 0.0))) / a
        x, y = (points[last - 1] + part * step).tolist()
    return pose.inverse() @ Pose2D(x, y, pose.theta)


def curvature_to(carrot: Pose2D) -> float:
    """Return the curvature of the arc from the robot to a point in its frame, positive to the left [1/m]."""
    squared = carrot.x * carrot.x + carrot.y * carrot.y
    return 2.0 * carrot.y / squared if squared > STANDING * STANDING else 0.0


def legs_of(poses: Poses) -> list[Poses]:
    """Split a plan wherever it turns by more than a right angle; each leg starts at the end of the one before."""
    poses = np.asarray(poses, dtype=np.float64)
    steps = np.diff(poses[:, :2], axis=0)
    moves = np.flatnonzero(np.hypot(steps[:, 0], steps[:, 1]) > STANDING)
    vectors = steps[moves]
    back = (vectors[:-1] * vectors[1:]).sum(axis=1) < 0.0
    cuts = [0, *moves[1:][back].tolist(), len(poses) - 1]
    return [poses[first : last + 1] for first, last in itertools.pairwise(cuts)]
