"""Whole units for searches from cell to cell: finer than those of the fields, so that no detour hides in rounding.

Five times a weight is a whole number: 250 + 4·cost, or 1265 for an unknown cell. A map whose weights have a common
divisor is counted in that; so each cell of a map of one cost weighs 1. A cardinal move is 5741 times that and a
diagonal one 8119 times: 8119/5741 is a convergent of √2. The cost of a path is then off by less than `RELATIVE_ERROR`
of itself, and a path that is cheapest in units is at most twice that dearer than the cheapest.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.weights import SQRT2, exact_weights, passable

CARDINAL = 5741
DIAGONAL = 8119

RELATIVE_ERROR = abs(DIAGONAL / CARDINAL / SQRT2 - 1.0)
"""7.6e-9: a metre in a hundred thousand kilometres."""

_WHOLE = 5


def unit_weights(occurring: NDArray[np.bool_], allow_unknown: bool) -> NDArray[np.int64]:
    """Return what entering a cell weighs.

    Parameters
    ----------
    occurring : (256,) array
        Which cost bytes the map has.
    allow_unknown : bool
        Whether unknown cells may be entered.

    Returns
    -------
    (2, 256) array
        By cardinal and by diagonal moves; 0 where no plan leads, and for costs that do not occur.
    """
    entered = passable(allow_unknown) & occurring
    whole = np.zeros(256, np.int64)
    whole[entered] = np.rint(exact_weights()[entered] * _WHOLE)
    whole //= max(1, int(np.gcd.reduce(whole)))
    return np.stack((whole * CARDINAL, whole * DIAGONAL))
