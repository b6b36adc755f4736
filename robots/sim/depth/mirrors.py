"""Mirrors and panes in front of a simulated depth camera.

A camera that projects a pattern measures, in a mirror, what the mirror shows: the reflected scene, behind the wall.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.maps.raycast import cast_rays
from robots.sim.depth.shapes import Shapes

Floats = NDArray[np.float64]


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
