"""Kernels: least depth of each column of a depth image, and its assignment to the beams of a scan."""

from collections.abc import Callable

import numpy as np
from numba import types
from numba.core.typing.templates import Signature
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Depths = NDArray[np.uint16] | NDArray[np.float32]
Nearest = Callable[[Depths, Depths, Depths, Depths], None]


def _nearest_signature(number: types.Number) -> Signature:
    rows, limits = types.Array(number, 2, "A", readonly=True), types.Array(number, 1, "C", readonly=True)
    return types.void(rows, limits, limits, number[::1])


@compiled([_nearest_signature(types.uint16), _nearest_signature(types.float32)])
def nearest(rows: Depths, low: Depths, high: Depths, least: Depths) -> None:
    """Lower ``least`` to the least depth of each column that is within its limits.

    Parameters
    ----------
    rows : (n, width) uint16 or float32 array
        Depths.
    low, high : (width,) array of the same type
        Limits of each column, both included. NaN is never within them.
    least : (width,) array of the same type
        In: upper bounds. Out: the least of these and of the depths.
    """
    for row in range(len(rows)):
        depths = rows[row]
        for column in range(len(depths)):
            depth = depths[column]
            counts = (depth >= low[column]) & (depth <= high[column]) & (depth < least[column])
            least[column] = depth if counts else least[column]


@compiled(
    types.void(
        types.Array(types.float32, 1, "C", readonly=True),
        types.Array(types.int32, 1, "C", readonly=True),
        types.float32[::1],
    ),
)  # fmt: skip
def spread(ranges: NDArray[np.float32], beams: NDArray[np.int32], scan: NDArray[np.float32]) -> None:
    """Lower the range of each beam to the least range of its columns; beams without a column are left unchanged.

    Parameters
    ----------
    ranges : (width,) float32 array
        Range of each column [m].
    beams : (width,) int32 array
        Index of the beam of each column.
    scan : (width,) float32 array
        In: upper bounds. Out: ranges of the beams [m].
    """
    for column in range(len(ranges)):
        beam = beams[column]
        scan[beam] = min(scan[beam], ranges[column])


def warm() -> None:
    """Call each kernel once."""
    for zeros in (np.zeros(2, np.uint16), np.zeros(2, np.float32)):
        nearest(zeros[None], zeros, zeros, zeros.copy())
    spread(np.zeros(2, np.float32), np.zeros(2, np.int32), np.zeros(2, np.float32))
