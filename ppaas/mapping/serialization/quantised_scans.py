"""Quantised scans: points as multiples of half a millimetre, normals as one of 4096 directions, as bytes.

A coordinate takes 16 bits. Scans with points beyond 16 m have steps of 1 mm, beyond 32 m of 2 mm, and so on, which is
far below the noise of lasers (1 cm). Steps are powers of two, so that values read and written again do not change.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidGraph
from ppaas.mapping.scan_points import ScanPoints

FINEST, COARSEST = -11, 12
"""Exponents of the finest and the coarsest step: 2**-11 m is 0.49 mm."""

DIRECTIONS = 4096
"""Number of directions of normals, 1.5 mrad apart."""

NONE, POINT, SURFACE, OPEN = 0, 1, 2, 3
"""States of a beam: without a reading, without a normal, with both, and free up to its point without a reading."""

BEAM_BYTES = 7
"""Size of a beam [bytes]."""

_MOST = (1 << 15) - 1

_ANGLES = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)

_NORMALS = np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES))).astype(np.float32)
"""Unit normals of all directions, (4096, 2)."""


def pack_scans(scans: ScanPoints) -> tuple[NDArray[np.int8], bytes]:
    """Return the exponents (k,) of the steps of some scans, and their beams as bytes.

    Parameters
    ----------
    scans : ScanPoints
        Stacked: (k, b, 2), (k, b, 2), (k, b).
    """
    points, is_open = scans.points, ~scans.valid & scans.points.any(axis=-1)
    exponents = _exponents(points)
    steps = np.ldexp(np.float64(1.0), exponents.astype(np.int64))[:, np.newaxis, np.newaxis]
    has_normal = scans.valid & scans.normals.any(axis=-1)
    angles = np.arctan2(scans.normals[..., 1], scans.normals[..., 0]) * (DIRECTIONS / (2.0 * math.pi))
    states = scans.valid.astype(np.uint8) + has_normal + is_open * np.uint8(OPEN)
    columns = (
        *np.moveaxis(_carried(np.rint(points / steps).astype(np.int64), scans.valid | is_open), -1, 0),
        _carried(np.rint(angles).astype(np.int64) % DIRECTIONS, has_normal),
    )
    # Differences from beam to beam are small, and their high bytes nearly constant: that is what zlib compresses.
    differences = [np.diff(column, axis=-1, prepend=0).astype(np.uint16) for column in columns]
    return exponents, b"".join((*map(_planes, differences), states.tobytes()))


def unpack_scans(exponents: NDArray[np.int8], data: memoryview | bytes, beams: int) -> ScanPoints:
    """Return the scans, stacked, of the result of `pack_scans`.

    Parameters
    ----------
    exponents : (k,) int8 array
    data : memoryview or bytes
        `BEAM_BYTES` for each beam.
    beams : int
        Number of beams of a scan.

    Raises
    ------
    InvalidGraph
        A number is out of range.
    """
    shape = len(exponents), beams
    planes = np.frombuffer(data, np.uint8).reshape(BEAM_BYTES, *shape)
    states = planes[6]
    if np.any(states > OPEN) or np.any((exponents < FINEST) | (exponents > COARSEST)):
        raise InvalidGraph("the pose graph has scans with values out of range: save it again")
    valid, has_normal = (states == POINT) | (states == SURFACE), states == SURFACE
    x, y, directions = (_sums(planes[2 * k : 2 * k + 2]) for k in range(3))
    steps = np.ldexp(np.float32(1.0), exponents.astype(np.int32))[:, np.newaxis]
    points, normals = np.zeros((*shape, 2), np.float32), np.zeros((*shape, 2), np.float32)
    points[..., 0], points[..., 1] = x * steps, y * steps
    points[states == NONE] = 0.0
    normals[has_normal] = _NORMALS[directions[has_normal] % DIRECTIONS]
    return ScanPoints(points, normals, valid)


def _exponents(points: NDArray[np.float32]) -> NDArray[np.int8]:
    """Return the exponents (k,) of the finest steps in which the coordinates of each scan fit 16 bits."""
    farthest = np.abs(points).max(axis=(1, 2), initial=0.0).astype(np.float64)
    exponents = np.full(len(points), FINEST)
    while np.any(more := np.rint(farthest / np.ldexp(1.0, exponents)) > _MOST):
        exponents[more] += 1
    if np.any(exponents > COARSEST):
        raise InvalidGraph(f"a scan has a point {farthest.max():g} m away: set max_laser_range to that of the laser")
    return exponents.astype(np.int8)


def _carried(values: NDArray[np.int64], given: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return values (k, b, …) along the beams, in which those not given repeat the last one, or are 0."""
    last = np.maximum.accumulate(np.where(given, np.arange(given.shape[1]), -1), axis=1)
    if values.ndim == 3:
        last = last[..., np.newaxis]
    return np.where(last >= 0, np.take_along_axis(values, np.maximum(last, 0), axis=1), 0)


def _planes(values: NDArray[np.uint16]) -> bytes:
    """Return the low bytes of all values, then the high bytes."""
    return (values & 0xFF).astype(np.uint8).tobytes() + (values >> 8).astype(np.uint8).tobytes()


def _sums(planes: NDArray[np.uint8]) -> NDArray[np.int16]:
    """Return the sums of the differences along the beams, modulo 2**16."""
    differences = planes[0].astype(np.uint16) | (planes[1].astype(np.uint16) << 8)
    sums: NDArray[np.uint16] = np.add.accumulate(differences, axis=1, dtype=np.uint16)
    return sums.view(np.int16)
