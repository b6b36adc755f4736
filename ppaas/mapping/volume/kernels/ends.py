"""Kernel: ends of the rays of a point cloud, clipped to the maximum range, and the box of keys around them.

Source: ``OctomapServer::insertScan`` of octomap_server, and ``OccupancyOcTreeBase::computeUpdate`` of
OctoMap. As there, coordinates, directions and lengths are float32.
"""

import math
from collections.abc import Callable

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.serial import serial_copy

MIDDLE = 32768
"""Key at 0 m."""

NONE, HIT, PASSED, CUT = 0, 1, 2, 3
"""Kind of a ray: it is ignored; it ends at an obstacle; its end shows nothing; it was cut at the maximum range, so that
its end is free, as in octomap_server: the library OctoMap leaves the voxel of that end as it was."""

FindEnds = Callable[
    [NDArray[np.float32], NDArray[np.float32], float, float, NDArray[np.uint8], NDArray[np.int64]], None
]


@compiled(inline="always")
def key_of(coordinate: float, factor: float) -> int:
    """Return the key of a coordinate [m]; ``factor`` is 1 / resolution [1/m]."""
    return math.floor(factor * coordinate) + MIDDLE


@compiled(inline="always")
def _end(ends: NDArray[np.float32], i: int, origin: NDArray[np.float32], max_range: float) -> int:
    """Cut a ray at the maximum range, and return its kind without regard to the range of keys."""
    dx, dy, dz = ends[i, 0] - origin[0], ends[i, 1] - origin[1], ends[i, 2] - origin[2]
    distance = math.sqrt(np.float64(dx * dx + dy * dy + dz * dz))
    if not distance < np.inf:  # a coordinate is not finite
        return NONE
    if max_range < 0.0 or distance <= max_range:
        return HIT
    length, most = np.float32(distance), np.float32(max_range)
    ends[i, 0] = origin[0] + dx / length * most
    ends[i, 1] = origin[1] + dy / length * most
    ends[i, 2] = origin[2] + dz / length * most
    return CUT


def _find_ends(
    ends: NDArray[np.float32],
    origin: NDArray[np.float32],
    factor: float,
    max_range: float,
    kinds: NDArray[np.uint8],
    bounds: NDArray[np.int64],
) -> None:
    """Cut rays at the maximum range and find the keys that they lie between.

    Parameters
    ----------
    ends : (n, 3) float32 array
        In: points. Out: ends of the rays. x, y, z [m] in the map frame.
    origin : (3,) float32 array
        Position of the sensor in the map frame [m]; its keys are valid.
    factor : float
        1 / resolution [1/m].
    max_range : float
        Maximum range [m]; negative for none.
    kinds : (n,) uint8 array
        Out: NONE, HIT or CUT. A ray that ends outside the range of keys is ignored.
    bounds : (parts, 2, 3) int64 array
        Out: least and greatest keys of the origin and all ends, of each part of the rays.
    """
    parts, count = len(bounds), len(ends)
    for part in prange(parts):
        low, high = np.empty(3, np.int64), np.empty(3, np.int64)
        for axis in range(3):
            low[axis] = high[axis] = key_of(origin[axis], factor)
        for i in range(count * part // parts, count * (part + 1) // parts):
            kind = _end(ends, i, origin, max_range)
            for axis in range(3):
                if not abs(factor * ends[i, axis]) <= MIDDLE or key_of(ends[i, axis], factor) >= 2 * MIDDLE:
                    kind = NONE
            kinds[i] = kind
            if kind != NONE:
                for axis in range(3):
                    key = key_of(ends[i, axis], factor)
                    low[axis], high[axis] = min(low[axis], key), max(high[axis], key)
        bounds[part, 0], bounds[part, 1] = low, high


find_ends_parallel: FindEnds = compiled(parallel=True)(_find_ends)
find_ends_serial: FindEnds = compiled(serial_copy(_find_ends))


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    for kernel in (find_ends_serial, find_ends_parallel):
        points, kinds = np.zeros((1, 3), np.float32), np.zeros(1, np.uint8)
        kernel(points, np.zeros(3, np.float32), 1.0, -1.0, kinds, np.zeros((1, 2, 3), np.int64))
