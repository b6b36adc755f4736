"""Weights of entering a cell: navfn's weights, in float64 and in the fixed point of the kernels.

The weight of a cell is 50 + 0.8·cost (navfn's ``COST_NEUTRAL`` and ``COST_FACTOR``); a diagonal move weighs √2 times as
much. A cost of 253 or more is blocked. An unknown cell, if it may be entered, weighs 253 (navfn's ``COST_OBS − 1``): a
little more than the most expensive known cell.

One unit of weight is 85 units of fixed point. As 85·50 and 85·0.8 are integers, cardinal weights are exact; only
diagonal ones are rounded, to the nearest unit. The relative error of a path's cost is below `RELATIVE_ERROR`, and the
cheapest path in fixed point exceeds the true optimum by at most twice that.
"""

import math

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
