"""Integer weights for A* and jump point search, finer than the fixed point of the cost fields.

Five times a weight is an integer: 250 + 4·cost, or 1265 for an unknown cell. The weights of a map are divided by their
greatest common divisor, so that each cell of a map of one cost weighs 1. A cardinal move weighs 5741 times that, a
diagonal one 8119 times: 8119/5741 is a convergent of √2. The relative error of a path's cost is below
`RELATIVE_ERROR`, and the cheapest path in these units exceeds the true optimum by at most twice that.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.weights import SQRT2, exact_weights, passable

CARDINAL = 5741
DIAGONAL = 8119

RELATIVE_ERROR = abs(DIAGONAL / CARDINAL / SQRT2 - 1.0)
"""Bound of the relative error: 7.6e-9, a metre in a hundred thousand kilometres."""

_WHOLE = 5
"""Factor that makes all weights integers."""


def unit_weights(occurring: NDArray[np.bool_], allow_unknown: bool) -> NDArray[np.int64]:
    """Return the integer weights of entering a cell.

    Parameters
    ----------
    occurring : (256,) array
        Whether each cost byte occurs in the map.
    allow_unknown : bool
        Whether unknown cells may be entered.

    Returns
    -------
    (2, 256) array
        Weights of cardinal and diagonal moves, by cost byte; 0 for blocked costs and for those that do not occur.
    """
    entered = passable(allow_unknown) & occurring
    whole = np.zeros(256, np.int64)
    whole[entered] = np.rint(exact_weights()[entered] * _WHOLE)
    whole //= max(1, int(np.gcd.reduce(whole)))
    return np.stack((whole * CARDINAL, whole * DIAGONAL))
