"""Kernel: rays of a point cloud, marked as bits in the box of voxels around them.

The voxels are those of ``OcTreeBaseImpl::computeRayKeys`` of OctoMap (Amanatides and Woo, "A Fast Voxel Traversal
Algorithm for Ray Tracing", 1987). A ray enters each voxel but its first across a plane of x, y or z. So the traversal
splits into three loops without branches, one over the planes of each axis that the ray crosses; the position on the
other two axes is in fixed point and moves by a constant.

The box is W × H × D voxels, W a multiple of 64; voxel (x, y, z) has bit (z · H + y) · W + x of int64 words. Between the
keys of the rays and the faces of the box is at least one voxel, so that rounding cannot leave it.
"""

import math
from collections.abc import Callable

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.mapping.volume.kernels.ends import CUT, HIT, MIDDLE, NONE, key_of
from ppaas.maps.kernels.serial import serial_copy
from ppaas.maps.kernels.traversal import FRACTION, to_fixed

_TIE = 1 << (FRACTION - 22)
"""Offset of a fixed-point position by which rays through edges of voxels cross z before y before x, as in OctoMap."""

MarkRays = Callable[
    [
        NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.float32], float,
        NDArray[np.float32], NDArray[np.uint8],
    ],
    None,
]  # fmt: skip


@compiled(inline="always")
def _mark(bits: NDArray[np.int64], voxel: int) -> None:
    """Set the bit of a voxel. Most are set already: without a store, the loop does not wait for its own stores."""
    word, bit = bits[voxel >> 6], np.int64(1) << (voxel & 63)
    if word & bit == 0:
        bits[voxel >> 6] = word | bit


@compiled(inline="always")
def _cross(
    free: NDArray[np.int64],
    index: int,
    stride: int,
    count: int,
    first: float,
    spacing: float,
    a: tuple[float, float, int, int],
    b: tuple[float, float, int, int],
    end: int,
) -> None:
    """Mark the voxels behind the crossings with the planes of one axis, except the last voxel of the ray.

    Parameters
    ----------
    free : (words,) int64 array
        Modified: bits of the voxels that rays pass.
    index, stride : int
        Bit of the voxel behind the first crossing, at position 0 of the other two axes, and its change per crossing.
    count : int
        Number of crossings.
    first, spacing : float
        Distance along the ray of the first crossing and between two of them [m].
    a, b : tuple of float, float, int, int
        The other two axes: position at the start [voxels], its change [voxels/m], stride, and offset for ties.
    end : int
        Bit of the last voxel.
    """
    at, bt = to_fixed(a[0] + first * a[1]) + a[3], to_fixed(b[0] + first * b[1]) + b[3]
    da, db = to_fixed(spacing * a[1]), to_fixed(spacing * b[1])
    for _ in range(count):
        voxel = index + (at >> FRACTION) * a[2] + (bt >> FRACTION) * b[2]
        if voxel != end:
            _mark(free, voxel)
        index += stride
        at += da
        bt += db


@compiled(inline="always")
def _tie(slope: float, before: bool) -> int:
    """Return the offset for ties of an axis that is crossed before the axis of the loop, or after it."""
    return 0 if slope == 0.0 else _TIE if (slope > 0.0) == before else -_TIE


@compiled(inline="always")
def _first(key: int, origin: float, direction: float, resolution: float, length: float) -> float:
    """Return the distance along the ray at which it leaves its first voxel on one axis [m], with OctoMap's rounding."""
    if direction == 0.0:
        return 0.0
    half = np.float64(np.float32(resolution * 0.5))
    border = (key - MIDDLE + 0.5) * resolution + (half if direction > 0.0 else -half)
    return min(max((border - origin) / direction, 0.0), length)


@compiled
def _cast(
    free: NDArray[np.int64],
    occupied: NDArray[np.int64],
    box: NDArray[np.int64],
    origin: NDArray[np.float32],
    resolution: float,
    end: NDArray[np.float32],
    kind: int,
) -> None:
    """Mark one ray; see `mark_rays_serial`."""
    factor = 1.0 / resolution
    sy, sz = box[3], box[3] * box[4]
    kx, ky, kz = key_of(origin[0], factor), key_of(origin[1], factor), key_of(origin[2], factor)
    ex, ey, ez = key_of(end[0], factor), key_of(end[1], factor), key_of(end[2], factor)
    x, y, z = kx - box[0], ky - box[1], kz - box[2]
    last = ex - box[0] + (ey - box[1]) * sy + (ez - box[2]) * sz
    if kind == HIT:
        _mark(occupied, last)
    elif kind == CUT:
        _mark(free, last)
    start = x + y * sy + z * sz
    if start == last:
        return
    _mark(free, start)
    # Unit direction, in float32 as in OctoMap; slopes in voxels per metre; start in voxels from the corner of the box.
    dx, dy, dz = end[0] - origin[0], end[1] - origin[1], end[2] - origin[2]
    norm = np.float32(math.sqrt(np.float64(dx * dx + dy * dy + dz * dz)))
    ux, uy, uz, length = float(dx / norm), float(dy / norm), float(dz / norm), float(norm)
    fx, fy, fz = ux * factor, uy * factor, uz * factor
    px = origin[0] * factor + (MIDDLE - box[0])
    py = origin[1] * factor + (MIDDLE - box[1])
    pz = origin[2] * factor + (MIDDLE - box[2])
    if ex != kx and ux != 0.0:
        step, first = (1 if ux > 0.0 else -1), _first(kx, origin[0], ux, resolution, length)
        a, b = (py, fy, sy, _tie(fy, True)), (pz, fz, sz, _tie(fz, True))
        _cross(free, x + step, step, abs(ex - kx), first, resolution / abs(ux), a, b, last)
    if ey != ky and uy != 0.0:
        step, first = (sy if uy > 0.0 else -sy), _first(ky, origin[1], uy, resolution, length)
        a, b = (px, fx, 1, _tie(fx, False)), (pz, fz, sz, _tie(fz, True))
        _cross(free, y * sy + step, step, abs(ey - ky), first, resolution / abs(uy), a, b, last)
    if ez != kz and uz != 0.0:
        step, first = (sz if uz > 0.0 else -sz), _first(kz, origin[2], uz, resolution, length)
        a, b = (px, fx, 1, _tie(fx, False)), (py, fy, sy, _tie(fy, False))
        _cross(free, z * sz + step, step, abs(ez - kz), first, resolution / abs(uz), a, b, last)


def _mark_rays(
    free: NDArray[np.int64],
    occupied: NDArray[np.int64],
    box: NDArray[np.int64],
    origin: NDArray[np.float32],
    resolution: float,
    ends: NDArray[np.float32],
    kinds: NDArray[np.uint8],
) -> None:
    """Mark the voxels that rays pass and those that they end in. Each part of the rays has bits of its own.

    Parameters
    ----------
    free, occupied : (parts, words) int64 array
        Modified: bits of the voxels that rays pass, and that rays end in. A voxel may be in both.
    box : (6,) int64 array
        Keys of the least voxel of the box (x, y, z), and its size W, H, D [voxels].
    origin : (3,) float32 array
        Position of the sensor in the map frame [m].
    resolution : float
        Edge of a voxel [m].
    ends, kinds
        Rays, as found by `ppaas.mapping.volume.kernels.ends`.
    """
    parts, count = len(free), len(ends)
    for part in prange(parts):
        for i in range(count * part // parts, count * (part + 1) // parts):
            if kinds[i] != NONE:
                _cast(free[part], occupied[part], box, origin, resolution, ends[i], kinds[i])


mark_rays_parallel: MarkRays = compiled(parallel=True)(_mark_rays)
mark_rays_serial: MarkRays = compiled(serial_copy(_mark_rays))


def warm() -> None:
    """Call the kernels once, so that they are compiled or loaded from the cache."""
    box = np.array([MIDDLE - 8, MIDDLE - 8, MIDDLE - 8, 64, 16, 16])
    free, ends, kinds = np.zeros((1, 256), np.int64), np.ones((1, 3), np.float32), np.ones(1, np.uint8)
    for kernel in (mark_rays_serial, mark_rays_parallel):
        kernel(free, free, box, np.zeros(3, np.float32), 1.0, ends, kinds)
