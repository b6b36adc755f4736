"""Solid shapes of which simulated bodies and furniture consist: capsules, ellipsoids and boxes."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D

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
