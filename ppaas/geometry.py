"""Poses in the plane and in space, in metres and radians; yaw is counter-clockwise from x (REP-103)."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Poses = NDArray[np.float64]
"""(n, 7) array with rows x, y, z [m], qx, qy, qz, qw, the layout of ``geometry_msgs/Pose``."""

FARTHEST = 1e9
"""Largest coordinate of a position [m], as REST has it: further than the Moon.

Sums of far larger ones lose the metres in which a map is, so that a pose would be wrong without a sign.
"""


class Pose2D(NamedTuple):
    """Pose in the plane: x, y [m], theta [rad]."""

    x: float
    y: float
    theta: float = 0.0

    def __matmul__(self, other: "Pose2D") -> "Pose2D":
        """Compose two poses: transform ``other`` from the frame at this pose into the frame that this pose is in."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2D(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap_angle(self.theta + other.theta),
        )

    def inverse(self) -> "Pose2D":
        """Return the inverse pose: ``p @ p.inverse()`` is the identity."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2D(-c * self.x - s * self.y, s * self.x - c * self.y, wrap_angle(-self.theta))

    def distance_to(self, other: "Pose2D") -> float:
        """Return the Euclidean distance between the positions [m]; headings are ignored."""
        return math.hypot(other.x - self.x, other.y - self.y)

    def is_finite(self) -> bool:
        """Return whether no component is NaN or infinite."""
        return all(map(math.isfinite, self))

    def is_near(self) -> bool:
        """Return whether its position is within `FARTHEST` of the origin."""
        return abs(self.x) <= FARTHEST and abs(self.y) <= FARTHEST


def wrap_angle(angle: float) -> float:
    """Wrap an angle to [−π, π)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def yaw_of(qx: float, qy: float, qz: float, qw: float) -> float:
    """Return the yaw [rad] of a quaternion, which need not be normalised."""
    return math.atan2(2.0 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz)


def quaternion_of(yaw: float) -> tuple[float, float, float, float]:
    """Return the quaternion (qx, qy, qz, qw) of a rotation about z by ``yaw`` [rad]."""
    return 0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)


def poses_along(points: NDArray[np.float64], goal_theta: float | None = None) -> Poses:
    """Return poses at points, each heading for the next point.

    Parameters
    ----------
    points : (n, 2) array
        x, y [m].
    goal_theta : float, optional
        Heading of the last pose [rad]; by default the heading of the pose before it.

    Returns
    -------
    (n, 7) array
    """
    n = len(points)
    poses = np.zeros((n, 7))
    poses[:, :2] = points
    yaw = np.zeros(n)
    if n > 1:
        steps = np.diff(points, axis=0)
        yaw[:-1] = np.arctan2(steps[:, 1], steps[:, 0])
        yaw[-1] = yaw[-2]
    if n and goal_theta is not None:
        yaw[-1] = goal_theta
    poses[:, 5] = np.sin(yaw / 2.0)
    poses[:, 6] = np.cos(yaw / 2.0)
    return poses


def convex_outline(points: ArrayLike) -> NDArray[np.float64]:
    """Return the convex hull of (n, 2) points as (m, 2) corners, counter-clockwise (Andrew's monotone chain, 1979)."""
    ordered = sorted(set(map(tuple, np.asarray(points, np.float64).tolist())))
    halves = []
    for line in (ordered, ordered[::-1]):
        half: list[tuple[float, ...]] = []
        for point in line:
            while len(half) > 1 and not _turns_left(half[-2], half[-1], point):
                half.pop()
            half.append(point)
        halves.append(half)
    return np.array(halves[0][:-1] + halves[1][:-1] if len(ordered) > 1 else ordered)


def reach_of(outline: NDArray[np.float64]) -> float:
    """Return the distance from the origin to the farthest of the (n, 2) corners of an outline."""
    return float(np.hypot(outline[:, 0], outline[:, 1]).max())


def within_hull(
    hull: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64], margin: float
) -> NDArray[np.bool_]:
    """Return a mask of the points that are in a convex outline, or at most a margin beyond its edges.

    Parameters
    ----------
    hull : (n, 2) array
        Corners, counter-clockwise [m].
    x, y : array
        Coordinates of the points, of the same shape [m].
    margin : float
        Distance beyond the edges [m].
    """
    inside = np.ones(np.broadcast(x, y).shape, np.bool_)
    for (ax, ay), (bx, by) in zip(hull, np.roll(hull, -1, axis=0), strict=True):
        beyond = (x - ax) * (by - ay) - (y - ay) * (bx - ax)
        inside &= beyond <= margin * math.hypot(bx - ax, by - ay)
    return inside


def _turns_left(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0
