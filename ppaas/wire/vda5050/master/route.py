"""Route of an AGV: a path with few corners, each of which becomes a node of an order."""

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.polygons import Points, distances_to_edges

TOLERANCE = 0.05
"""Distance by which the route may miss the path [m]; larger if it would have more corners than `MAX_CORNERS`."""

MAX_CORNERS = 500

SAME_PLACE = 0.05
"""Distance below which two corners are one [m]."""

SAME_HEADING = 0.2
"""Difference of headings below which two routes end alike [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class Route:
    """Corners from the start to the goal.

    Attributes
    ----------
    points : (n, 2) array
        Corners [m], at least one.
    theta : float or None
        Heading at the end [rad]; None if any will do.
    """

    points: Points
    theta: float | None = None

    @property
    def length(self) -> float:
        """Length [m]."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    def after(self, x: float, y: float, near: float) -> "Route | None":
        """Return the rest of the route from its point nearest to a place; None if that is farther than ``near``.

        The first corner of the rest is the place itself.
        """
        index, apart = nearest_edge(self.points, x, y)
        if apart > near:
            return None
        rest = self.points[min(index + 1, len(self.points) - 1) :]
        first = np.array([[x, y]])
        while len(rest) > 1 and float(np.hypot(*(rest[0] - first[0]))) < SAME_PLACE:
            rest = rest[1:]
        return Route(np.concatenate((first, rest)), self.theta)

    def before(self, x: float, y: float) -> "Route":
        """Return the route up to its point nearest to a place, which ends it."""
        index, _ = nearest_edge(self.points, x, y)
        return Route(np.concatenate((self.points[: index + 1], np.array([[x, y]]))))

    def is_near(self, other: "Route", near: float) -> bool:
        """Return whether both end at one place, and no corner of either is farther than ``near`` from the other [m]."""
        if float(np.hypot(*(self.points[-1] - other.points[-1]))) > near or not _same(self.theta, other.theta):
            return False
        return all(
            nearest_edge(there, *corner)[1] <= near
            for here, there in ((self.points, other.points), (other.points, self.points))
            for corner in here
        )


def route_of(poses: Sequence[Pose2D], tolerance: float = TOLERANCE) -> Route:
    """Return the route of a path, by the algorithm of Ramer, Douglas and Peucker.

    Parameters
    ----------
    poses : sequence of Pose2D
    tolerance : float
        Largest distance of the path from the route [m].

    Raises
    ------
    InvalidInput
        The path is empty, or a number is not finite.
    """
    points = np.array([(pose.x, pose.y) for pose in poses], dtype=np.float64).reshape(-1, 2)
    if not len(points) or not all(pose.is_finite() for pose in poses):
        raise InvalidInput("a path needs at least one pose, and finite numbers")
    return Route(points[_corners(points, tolerance)], poses[-1].theta)


def nearest_edge(points: Points, x: float, y: float) -> tuple[int, float]:
    """Return the index of the edge that is nearest to a place, and its distance [m]; one point is its own edge."""
    place = np.array((x, y))
    if len(points) == 1:
        return 0, float(np.hypot(*(points[0] - place)))
    apart = distances_to_edges(points[:-1], points[1:], place)
    index = int(np.argmin(apart))
    return index, float(apart[index])


def _corners(points: Points, tolerance: float) -> list[int]:
    """Return the indices of at most `MAX_CORNERS` points; those that are farthest from the route come first."""
    kept, parts = {0, len(points) - 1}, [_farthest(points, 0, len(points) - 1)]
    while parts and len(kept) < MAX_CORNERS:
        apart, first, middle, last = heapq.heappop(parts)
        if -apart <= tolerance:
            break
        kept.add(middle)
        heapq.heappush(parts, _farthest(points, first, middle))
        heapq.heappush(parts, _farthest(points, middle, last))
    return sorted(kept)


def _farthest(points: Points, first: int, last: int) -> tuple[float, int, int, int]:
    """Return the negative distance of the point between two others that is farthest from their edge, and the three."""
    if last - first < 2:
        return 0.0, first, first, last
    apart = distances_to_edges(points[first], points[last], points[first + 1 : last])
    index = int(np.argmax(apart))
    return -float(apart[index]), first, first + 1 + index, last


def _same(theta: float | None, other: float | None) -> bool:
    if theta is None or other is None:
        return theta is other
    return abs(math.remainder(theta - other, math.tau)) < SAME_HEADING
