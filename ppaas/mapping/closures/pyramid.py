"""Likelihood pyramid: a blurred grid of the points of a submap, with maxima that bound the scores of many motions."""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.closures.kernels import pyramid as kernels

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
