"""Yardstick of 3D mapping: OctoMap's insertion of point clouds as it is written there, compiled, with hash sets.

Each ray is traversed voxel by voxel (``computeRayKeys``), and its keys go into a set; a dict holds the log-odds.
"""

import math
from typing import Any

import numpy as np
from numba import njit, types
from numba.typed import Dict
from numpy.typing import NDArray

MIDDLE = 32768
_FACTOR = np.int64(-7046029254386353131)


@njit(nogil=True)
def code_of(x: Any, y: Any, z: Any) -> Any:
    """Return a number for a key, whose low bits depend on all axes: numba's sets and dicts use them as hash."""
    code = (z << 32 | y << 16 | x) * _FACTOR
    return code ^ (code >> 32 & 0xFFFFFFFF)


@njit(nogil=True)
def _cast(free, origin, end, resolution):  # type: ignore[no-untyped-def]
    """Add the voxels that a ray passes to a set; return the code of its last one."""
    factor = 1.0 / resolution
    key, last, step = np.empty(3, np.int64), np.empty(3, np.int64), np.zeros(3, np.int64)
    reach, spacing = np.full(3, np.inf), np.full(3, np.inf)
    for i in range(3):
        key[i], last[i] = math.floor(factor * origin[i]) + MIDDLE, math.floor(factor * end[i]) + MIDDLE
    target = code_of(last[0], last[1], last[2])
    code = code_of(key[0], key[1], key[2])
    if code == target:
        return target
    free.add(code)
    dx, dy, dz = end[0] - origin[0], end[1] - origin[1], end[2] - origin[2]
    length = np.float32(math.sqrt(np.float64(dx * dx + dy * dy + dz * dz)))
    half = np.float64(np.float32(resolution * 0.5))
    for i in range(3):
        direction = np.float64((end[i] - origin[i]) / length)
        if direction != 0.0:
            step[i] = 1 if direction > 0.0 else -1
            reach[i] = ((key[i] - MIDDLE + 0.5) * resolution + step[i] * half - origin[i]) / direction
            spacing[i] = resolution / abs(direction)
    while True:
        axis = 0 if reach[0] < reach[1] else 1
        axis = axis if reach[axis] < reach[2] else 2
        key[axis] += step[axis]
        reach[axis] += spacing[axis]
        code = code_of(key[0], key[1], key[2])
        if code == target or min(reach[0], reach[1], reach[2]) > length:
            return target
        free.add(code)


@njit(nogil=True)
def _insert(voxels, points, origin, lengths, model):  # type: ignore[no-untyped-def]
    resolution, max_range = lengths
    free = {np.int64(-1)}
    occupied = {np.int64(-1)}
    most = np.float32(max_range)
    for i in range(len(points)):
        end = points[i].copy()
        dx, dy, dz = end[0] - origin[0], end[1] - origin[1], end[2] - origin[2]
        distance = math.sqrt(np.float64(dx * dx + dy * dy + dz * dz))
        hit = distance <= max_range
        if not hit:
            for axis in range(3):
                end[axis] = origin[axis] + (end[axis] - origin[axis]) / np.float32(distance) * most
        last = _cast(free, origin, end, resolution)
        if hit:
            occupied.add(last)
    free.discard(np.int64(-1))
    occupied.discard(np.int64(-1))
    for code in free:
        if code not in occupied:
            voxels[code] = min(max(voxels.get(code, np.float32(0.0)) + model[1], model[2]), model[3])
    for code in occupied:
        voxels[code] = min(max(voxels.get(code, np.float32(0.0)) + model[0], model[2]), model[3])


@njit(nogil=True)
def _copy(voxels, codes, values):  # type: ignore[no-untyped-def]
    for i, (code, value) in enumerate(voxels.items()):
        codes[i], values[i] = code, value


class SetVolume:
    """Log-odds of voxels in a dict by the code of their keys, see `code_of`."""

    def __init__(self, resolution: float, max_range: float, model: tuple[np.float32, ...]) -> None:
        self._lengths, self._model = (resolution, max_range), tuple(model)
        self._voxels = Dict.empty(types.int64, types.float32)

    def insert(self, points: NDArray[np.float32], origin: NDArray[np.float32]) -> None:
        """Add a point cloud."""
        _insert(self._voxels, points, origin, self._lengths, self._model)

    def log_odds(self) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        """Return the codes of the known voxels, sorted, and their log-odds, (n,) each."""
        codes, values = np.empty(len(self._voxels), np.int64), np.empty(len(self._voxels), np.float32)
        _copy(self._voxels, codes, values)
        order = np.argsort(codes)
        return codes[order], values[order]
