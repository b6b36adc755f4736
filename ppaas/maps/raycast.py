"""What a laser would measure in a grid."""

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
        Not 0 where a ray ends. Outside the grid nothing stops a ray, and one that begins there may enter.
    info : GridInfo
        Where the grid lies; its origin may be turned.
    origin : Pose2D
        Where the rays begin, in the frame of the map; angles count from its heading.
    angles : (n,) array
        Counter-clockwise [rad].
    range_max : float
        Longest ray [m].

    Returns
    -------
    (n,) float64 array
        [m]; exact up to rounding, 0 where the origin lies in an occupied cell, infinite where there is no hit.

    Raises
    ------
    InvalidMap
        The cells are not those of the grid.
    InvalidInput
        A pose, an angle or a range that is not finite, or a negative range.
    """
    if occupied.shape != info.shape or occupied.dtype not in (np.uint8, np.bool_):
        raise InvalidMap(f"expected uint8 or bool cells of {info.shape}, got {occupied.dtype} of {occupied.shape}")
    directions = np.ascontiguousarray(angles, dtype=np.float64)
    if directions.ndim != 1 or not (origin.is_finite() and np.isfinite(directions).all()):
        raise InvalidInput("rays need a finite pose and a row of finite angles")
    if not (math.isfinite(range_max) and range_max >= 0.0):
        raise InvalidInput(f"the longest range must be a finite number of metres, not {range_max}")
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
