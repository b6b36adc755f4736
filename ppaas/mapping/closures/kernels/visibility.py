"""Kernel: contradictions between two scans, points that one laser measured where the other looked through."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled


@compiled
def agreement(
    points: NDArray[np.float32],
    valid: NDArray[np.bool_],
    other_points: NDArray[np.float32],
    other_valid: NDArray[np.bool_],
    pose: NDArray[np.float64],
    angle_min: float,
    angle_increment: float,
    tolerance: float,
) -> tuple[int, int]:
    """Return the number of points of a scan that another scan confirms, and that it contradicts.

    A point is compared with the beams of the other scan around its bearing. It is contradicted if all of them end
    beyond it: the other laser looked through the place. A point beyond their ends is hidden, and counts as neither.

    Parameters
    ----------
    points : (b, 2) float32 array
        Points of the scan in the frame of its laser [m].
    valid : (b,) bool array
        Points that were measured.
    other_points, other_valid : (b, 2) float32 array, (b,) bool array
        The other scan, in the frame of its laser.
    pose : (3,) array
        Pose of the scan's laser in the frame of the other: x, y [m], theta [rad].
    angle_min, angle_increment : float
        Direction of beam 0 and step from beam to beam [rad].
    tolerance : float
        Difference of ranges that still agrees [m].
    """
    beams = other_points.shape[0]
    c, s = math.cos(pose[2]), math.sin(pose[2])
    confirmed = contradicted = 0
    for i in range(points.shape[0]):
        if not valid[i]:
            continue
        x = pose[0] + c * points[i, 0] - s * points[i, 1]
        y = pose[1] + s * points[i, 0] + c * points[i, 1]
        turn = (math.atan2(y, x) - angle_min) % (2.0 * math.pi)
        if angle_increment < 0.0:
            turn -= 2.0 * math.pi
        beam = int(turn / angle_increment + 0.5)
        if beam < 1 or beam >= beams - 1:
            continue
        # Nearest and farthest end of the three beams around the point's bearing.
        nearest, farthest, count = np.inf, 0.0, 0
        for k in range(beam - 1, beam + 2):
            if other_valid[k]:
                r = math.hypot(other_points[k, 0], other_points[k, 1])
                nearest, farthest, count = min(nearest, r), max(farthest, r), count + 1
        if count < 3:
            continue
        r = math.hypot(x, y)
        if r < nearest - tolerance:
            contradicted += 1
        elif r <= farthest + tolerance:
            confirmed += 1
    return confirmed, contradicted


def warm() -> None:
    """Call the kernel once, so that it is compiled or loaded from the cache."""
    points, valid = np.ones((4, 2), np.float32), np.ones(4, np.bool_)
    agreement(points, valid, points, valid, np.zeros(3), 0.0, 0.5, 0.3)
