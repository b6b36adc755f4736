"""Solid shapes of which simulated bodies and furniture consist, and mirrors: capsules, ellipsoids, boxes, panes.

A camera that projects a pattern measures, in a mirror, what the mirror shows: the reflected scene, behind the wall.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.maps.raycast import cast_rays

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]

ELLIPSOID, BOX = 0.0, 1.0


@dataclass(frozen=True, slots=True)
class Shapes:
    """Shapes in one frame, z up.

    Parameters
    ----------
    capsules : (n, 7) array
        Both ends of a segment, and the radius around it [m].
    solids : (m, 13) array
        `BOX` or `ELLIPSOID`; the centre [m]; the 3 × 3 matrix, row-major, that maps an offset from the centre into the
        cube of half side 1 or the unit sphere.
    """

    capsules: Floats
    solids: Floats

    def placed(self, pose: Pose2D) -> "Shapes":
        """Return the shapes moved from the frame of a pose into the frame in which the pose is."""
        turn = _turn(pose.theta)
        return self.transformed(turn, np.array((pose.x, pose.y, 0.0)))

    def transformed(self, linear: Floats, offset: Floats) -> "Shapes":
        """Return the shapes with each point p at ``linear @ p + offset``; ``linear`` is orthogonal."""
        capsules, solids = self.capsules.copy(), self.solids.copy()
        capsules[:, :3] = capsules[:, :3] @ linear.T + offset
        capsules[:, 3:6] = capsules[:, 3:6] @ linear.T + offset
        solids[:, 1:4] = solids[:, 1:4] @ linear.T + offset
        solids[:, 4:] = (solids[:, 4:].reshape(-1, 3, 3) @ linear.T).reshape(-1, 9)
        return Shapes(capsules, solids)


def _turn(angle: float) -> Floats:
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array(((cosine, -sine, 0.0), (sine, cosine, 0.0), (0.0, 0.0, 1.0)))


@cache
def nothing() -> Shapes:
    """Return no shapes."""
    return Shapes(np.empty((0, 7)), np.empty((0, 13)))


def shapes_of(capsules: Iterable[Iterable[float]] = (), solids: Iterable[Iterable[float]] = ()) -> Shapes:
    """Return shapes of rows as `capsule`, `ellipsoid` and `box` return them."""
    return Shapes(
        np.array(list(capsules), np.float64).reshape(-1, 7), np.array(list(solids), np.float64).reshape(-1, 13)
    )


def joined(parts: Iterable[Shapes]) -> Shapes:
    """Return all shapes of several parts."""
    found = [nothing(), *parts]
    return Shapes(np.concatenate([part.capsules for part in found]), np.concatenate([part.solids for part in found]))


def capsule(start: Vector, end: Vector, radius: float) -> tuple[float, ...]:
    """Return a capsule: all points within ``radius`` of a segment [m]."""
    return (*start, *end, radius)


def ellipsoid(centre: Vector, half: Vector, yaw: float = 0.0, pitch: float = 0.0) -> tuple[float, ...]:
    """Return an ellipsoid by its half axes [m], turned by ``pitch`` about y (down at the front), then ``yaw`` [rad]."""
    return _solid(ELLIPSOID, centre, half, yaw, pitch)


def box(centre: Vector, half: Vector, yaw: float = 0.0, pitch: float = 0.0) -> tuple[float, ...]:
    """Return a box by half of its sides [m], turned by ``pitch`` about y (down at the front), then ``yaw`` [rad]."""
    return _solid(BOX, centre, half, yaw, pitch)


def _solid(kind: float, centre: Vector, half: Vector, yaw: float, pitch: float) -> tuple[float, ...]:
    cosine, sine = math.cos(pitch), math.sin(pitch)
    turn = _turn(yaw) @ np.array(((cosine, 0.0, sine), (0.0, 1.0, 0.0), (-sine, 0.0, cosine)))
    matrix = turn.T / np.array(half)[:, None]
    return (kind, *centre, *matrix.ravel().tolist())


# -- mirrors and panes in front of a simulated depth camera ------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Mirror:
    """Vertical rectangle that reflects, or that gives no reading.

    Parameters
    ----------
    x1, y1, x2, y2 : float
        Ends of its lower edge in the map [m].
    low, high : float
        Heights of its edges [m].
    reflects : bool
        False for a pane that swallows the pattern.
    """

    x1: float
    y1: float
    x2: float
    y2: float
    low: float = 0.0
    high: float = 2.0
    reflects: bool = True

    @property
    def normal(self) -> tuple[float, float]:
        """Unit vector across the mirror, to the left of the direction from its first end to its second."""
        length = math.hypot(self.x2 - self.x1, self.y2 - self.y1)
        return -(self.y2 - self.y1) / length, (self.x2 - self.x1) / length

    def image(self, shapes: Shapes, eye: Pose2D) -> Shapes:
        """Return the mirror images of the shapes whose centres are on the side of the camera."""
        normal = np.array((*self.normal, 0.0))
        base = np.array((self.x1, self.y1, 0.0))
        side = math.copysign(1.0, normal @ (np.array((eye.x, eye.y, 0.0)) - base))
        middles = 0.5 * (shapes.capsules[:, :3] + shapes.capsules[:, 3:6])
        ahead = Shapes(
            shapes.capsules[side * ((middles - base) @ normal) > 0.0],
            shapes.solids[side * ((shapes.solids[:, 1:4] - base) @ normal) > 0.0],
        )
        linear = np.eye(3) - 2.0 * np.outer(normal, normal)
        return ahead.transformed(linear, base - linear @ base)


def ranges_to(mirror: Mirror, eye: Pose2D, bearings: Floats) -> Floats:
    """Return the horizontal distance to a mirror along each bearing [m]; infinite beside it."""
    headings = bearings + eye.theta
    dx, dy = np.cos(headings), np.sin(headings)
    along_x, along_y = mirror.x2 - mirror.x1, mirror.y2 - mirror.y1
    right, up = mirror.x1 - eye.x, mirror.y1 - eye.y
    across = dx * along_y - dy * along_x
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (right * along_y - up * along_x) / across
        share = (right * dy - up * dx) / across
    hit = (np.abs(across) > 1e-9) & (distance > 0.0) & (share >= 0.0) & (share <= 1.0)
    return np.where(hit, distance, np.inf)


def reflected_ranges(
    mirror: Mirror,
    eye: Pose2D,
    bearings: Floats,
    used: NDArray[np.bool_],
    *,
    occupied: NDArray[np.bool_],
    info: GridInfo,
    reach: float,
) -> Floats:
    """Return the horizontal length of the rays that a mirror reflects, up to the wall that they meet.

    Parameters
    ----------
    mirror : Mirror
    eye : Pose2D
        Position of the camera.
    bearings : (n,) array
        Directions of the rays, from the heading of ``eye`` [rad].
    used : (n,) bool array
        Directions to compute; the others are infinite.
    occupied, info
        Occupied cells of the map, and its geometry.
    reach : float
        Longest range beyond the mirror [m].
    """
    to_mirror = ranges_to(mirror, eye, bearings)
    ranges = np.full(len(bearings), np.inf)
    normal_x, normal_y = mirror.normal
    # The reflected rays start a little in front of the mirror, which may hang on a wall.
    side = math.copysign(1.0, normal_x * (eye.x - mirror.x1) + normal_y * (eye.y - mirror.y1))
    start_x, start_y = 1e-3 * side * normal_x, 1e-3 * side * normal_y
    for k in np.flatnonzero(used & np.isfinite(to_mirror)):
        heading = eye.theta + float(bearings[k])
        dx, dy = math.cos(heading), math.sin(heading)
        inward = dx * normal_x + dy * normal_y
        turned = math.atan2(dy - 2.0 * inward * normal_y, dx - 2.0 * inward * normal_x)
        at = Pose2D(eye.x + to_mirror[k] * dx + start_x, eye.y + to_mirror[k] * dy + start_y, turned)
        ranges[k] = to_mirror[k] + cast_rays(occupied, info, at, np.zeros(1), reach)[0]
    return ranges
