"""Weights of entering a cell, navfn's in float64 and in the fixed point of the kernels; and padded maps of them."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, LETHAL_OBSTACLE, NO_INFORMATION

NEUTRAL = 50.0
FACTOR = 0.8
UNKNOWN = 253.0
SQRT2 = math.sqrt(2.0)

SCALE = 85
"""Units of fixed point per unit of weight. The least weight is then 4250, and a bucket of 4096 is narrower than any
move."""

RELATIVE_ERROR = 0.5 / (SCALE * NEUTRAL * SQRT2)
"""Bound of the relative error of a path's cost in fixed point: half a unit on the cheapest diagonal move."""


def exact_weights() -> NDArray[np.float64]:
    """Return the (256,) weight of each cost byte; the weight of 254 is infinite.

    253 has a weight as well: plans do not enter such a cell, but a robot that is in one has to get out.
    """
    weights = NEUTRAL + FACTOR * np.arange(256.0)
    weights[LETHAL_OBSTACLE] = np.inf
    weights[NO_INFORMATION] = UNKNOWN
    return weights


def fixed_weights() -> NDArray[np.int64]:
    """Return the (2, 256) weights of cardinal and diagonal moves in fixed point; the weight of 254 is 0."""
    weights = exact_weights()
    weights[LETHAL_OBSTACLE] = 0.0
    cardinal = np.rint(weights * SCALE).astype(np.int64)
    return np.stack((cardinal, np.rint(cardinal * SQRT2).astype(np.int64)))


def passable(allow_unknown: bool) -> NDArray[np.bool_]:
    """Return for each of the 256 cost bytes whether a plan may enter such a cell."""
    open_costs = np.arange(256) < INSCRIBED_INFLATED_OBSTACLE
    open_costs[NO_INFORMATION] = allow_unknown
    return open_costs


SLICE_BYTES = 1 << 20
"""Cells copied between two checks: about 1 ms if the memory is newly allocated."""


def padded(data: NDArray[np.uint8], check: Callable[[], None]) -> NDArray[np.uint8]:
    """Return (height + 2, width + 2) costs with a blocked cell on each side (see `field.kernels.layout`)."""
    height, width = data.shape
    costs = np.empty((height + 2, width + 2), np.uint8)
    costs[[0, -1]] = LETHAL_OBSTACLE
    costs[:, [0, -1]] = LETHAL_OBSTACLE
    rows = max(1, SLICE_BYTES // width)
    for first in range(0, height, rows):
        check()
        costs[first + 1 : min(first + rows, height) + 1, 1:-1] = data[first : first + rows]
    return costs


def blocking_weights(allow_unknown: bool) -> NDArray[np.int64]:
    """Return the (2, 256) weights of cardinal and diagonal moves in fixed point; 0 for blocked costs."""
    return np.where(passable(allow_unknown), fixed_weights(), 0)


def neighbour_offsets(stride: int) -> NDArray[np.int64]:
    """Return the (8,) index offsets of the neighbours of a cell: left, right, down, up, then the diagonals."""
    return np.array((-1, 1, -stride, stride, -stride - 1, -stride + 1, stride - 1, stride + 1))
