"""Ray casting: the ranges that a laser would measure in a grid."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.maps.kernels import raycast as kernels


def cast_rays(
    occupied: NDArray[np.uint8] | NDArray[np.bool_],
    info: GridInfo,
    origin: Pose2D,
    angles: ArrayLike,
    range_max: float,
) -> NDArray[np.float64]:
    """Return the distance from a pose to the first occupied cell in each direction.

    Parameters
    ----------
    occupied : (height, width) uint8 or bool array
        Not 0 in cells that stop a ray. Outside the grid a ray is never stopped; it may enter the grid from outside.
    info : GridInfo
        Geometry of the grid, whose origin may be rotated.
    origin : Pose2D
        Start of the rays, in the frame of the map.
    angles : (n,) array
        Directions of the rays relative to the heading of ``origin``, counter-clockwise [rad].
    range_max : float
        Longest range [m].

    Returns
    -------
    (n,) float64 array
        Ranges [m], exact up to rounding; 0 if the origin is in an occupied cell, infinite if nothing is hit.

    Raises
    ------
    InvalidMap
        ``occupied`` does not match ``info``, or has another type.
    InvalidInput
        The pose, an angle or ``range_max`` is not finite, or ``range_max`` is negative.
    """
    if occupied.shape != info.shape or occupied.dtype not in (np.uint8, np.bool_):
        raise InvalidMap(
            f"expected uint8 or bool cells of shape {info.shape}, not {occupied.dtype} of shape {occupied.shape}"
        )
    directions = np.ascontiguousarray(angles, dtype=np.float64)
    if directions.ndim != 1 or not (origin.is_finite() and np.isfinite(directions).all()):
        raise InvalidInput("the origin and the angles of rays must be finite, and the angles one-dimensional")
    if not (math.isfinite(range_max) and range_max >= 0.0):
        raise InvalidInput(f"range_max must be finite and not negative, not {range_max}")
    start = info.origin.inverse() @ origin
    cells = np.ascontiguousarray(occupied).view(np.uint8)
    ranges: NDArray[np.float64] = kernels.cast_rays(
        cells,
        start.x / info.resolution,
        start.y / info.resolution,
        directions + start.theta,
        range_max / info.resolution,
    )
    ranges *= info.resolution
    return ranges
