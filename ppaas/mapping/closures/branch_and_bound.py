"""Search of a window for the motion under which points fit a likelihood pyramid best; and that pyramid of a submap."""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.kernels import pyramid as kernels
from ppaas.mapping.closures.kernels.branch_and_bound import best_motion

# -- likelihood pyramid: maxima bound the scores of many motions -------------------------------------------------------

BLUR_REACH = 2.2
"""Standard deviations beyond which the blur of a point is cut off."""

MAX_CELLS = 1 << 24
"""Largest number of cells of a grid; beyond, the area is cut."""


@dataclass(frozen=True, slots=True, eq=False)
class LikelihoodPyramid:
    """Pyramid of a blurred grid.

    Parameters
    ----------
    values : (n,) uint8 array
        Values of all levels.
    sizes : (levels, 3) int64 array
        First value, height and width of each level.
    corner : (2,) array
        Lower-left corner of cell (0, 0) [m].
    resolution : float
        Edge of a cell [m].
    """

    values: NDArray[np.uint8]
    sizes: NDArray[np.int64]
    corner: NDArray[np.float64]
    resolution: float


@dataclass(frozen=True, slots=True)
class Blur:
    """Resolution and blur of a pyramid.

    Parameters
    ----------
    resolution : float
        Edge of a cell [m].
    deviation : float
        Standard deviation of the blur of a point [m].
    """

    resolution: float = 0.1
    deviation: float = 0.1


@cache
def _blur_values(blur: Blur) -> NDArray[np.uint8]:
    """Return the values around a point, 255 at the point itself."""
    r = math.ceil(BLUR_REACH * blur.deviation / blur.resolution)
    y, x = np.mgrid[-r : r + 1, -r : r + 1] * blur.resolution
    values: NDArray[np.uint8] = np.rint(255.0 * np.exp(-(x * x + y * y) / (2.0 * blur.deviation**2))).astype(np.uint8)
    values.flags.writeable = False
    return values


def build_pyramid(
    points: NDArray[np.float64], reach: tuple[float, float], blur: Blur, levels: int
) -> LikelihoodPyramid:
    """Return the pyramid of points.

    Parameters
    ----------
    points : (n, 2) array
        Points, in the frame of the search [m].
    reach : (float, float)
        Half the size of the area around the origin, in x and y [m]; points beyond are left out.
    blur : Blur
    levels : int
        Number of levels, at least 1.
    """
    margin = BLUR_REACH * blur.deviation + blur.resolution
    limit = np.array(reach)
    if len(points):
        low = np.maximum(points.min(axis=0) - margin, -limit)
        high = np.minimum(points.max(axis=0) + margin, limit)
    else:
        low = high = np.zeros(2)
    width, height = np.clip(np.ceil((high - low) / blur.resolution), 1, math.isqrt(MAX_CELLS)).astype(int)
    grid = kernels.blurred_grid(points, low[0], low[1], blur.resolution, height, width, _blur_values(blur))
    values, sizes = kernels.build_levels(grid, levels)
    return LikelihoodPyramid(values, sizes, low, blur.resolution)


# -- the search --------------------------------------------------------------------------------------------------------

MOST_LEVELS = 7
"""Largest number of levels of a pyramid: squares of 64 cells."""


@dataclass(frozen=True, slots=True)
class MotionWindow:
    """Window of motions around the origin of the frame of a search.

    Parameters
    ----------
    x, y : float
        Largest translation in both directions [m].
    turn : float
        Largest rotation in both directions [rad].
    step : float
        Step of the rotation [rad].
    """

    x: float
    y: float
    turn: float
    step: float = 0.015

    def turns(self) -> NDArray[np.float64]:
        """Return the rotations [rad], ascending, 0 among them."""
        n = math.ceil(self.turn / self.step)
        turns: NDArray[np.float64] = self.step * np.arange(-n, n + 1, dtype=np.float64)
        return turns

    def cells(self, resolution: float) -> NDArray[np.int64]:
        """Return the largest translation in x and y [cells]."""
        return np.array([math.ceil(self.x / resolution), math.ceil(self.y / resolution)])

    def levels(self, resolution: float) -> int:
        """Return the number of levels of a pyramid for this window: the highest has some ten squares a side."""
        edge = max(1.0, float(self.cells(resolution).max()) / 5.0)
        return min(max(round(math.log2(edge)) + 1, 1), MOST_LEVELS)


@dataclass(frozen=True, slots=True)
class Excluded:
    """Motions that a search leaves out: those near one motion.

    Parameters
    ----------
    motion : Pose2D
        Centre.
    radius : float
        Translations nearer than this are left out [m] …
    turn : float
        … if their rotations differ by at most this [rad].
    """

    motion: Pose2D
    radius: float
    turn: float


@dataclass(frozen=True, slots=True)
class Match:
    """Result of a search.

    Parameters
    ----------
    motion : Pose2D
        Rotation about the origin of the frame of the search, then translation.
    score : float
        Mean value of the grid under the points, from 0 to 1.
    """

    motion: Pose2D
    score: float


def search(
    pyramid: LikelihoodPyramid,
    points: NDArray[np.float64],
    window: MotionWindow,
    least: float = 0.0,
    excluded: Excluded | None = None,
) -> Match | None:
    """Return the best motion in the window, or None if none scores more than ``least``.

    Parameters
    ----------
    pyramid : LikelihoodPyramid
        Grid of the older points, in the frame of the search.
    points : (n, 2) array
        Points to move, in the frame of the search [m].
    window : MotionWindow
    least : float
        The score has to be larger.
    excluded : Excluded, optional
        Motions left out.
    """
    if not len(points):
        return None
    turns, half = window.turns(), window.cells(pyramid.resolution)
    full = 255.0 * len(points)
    circle = _excluded_cells(excluded, half, pyramid.resolution)
    turn, du, dv, total = best_motion(
        pyramid.values,
        pyramid.sizes,
        pyramid.corner,
        pyramid.resolution,
        points,
        turns,
        half,
        int(least * full),
        circle,
    )
    if turn < 0:
        return None
    moved = Pose2D(du * pyramid.resolution, dv * pyramid.resolution, float(turns[turn]))
    return Match(moved, total / full)


def _excluded_cells(excluded: Excluded | None, half: NDArray[np.int64], resolution: float) -> NDArray[np.float64]:
    if excluded is None:
        return np.zeros(5)
    motion = excluded.motion
    u, v = motion.x / resolution + half[0], motion.y / resolution + half[1]
    return np.array([u, v, excluded.radius / resolution, excluded.turn, motion.theta])
