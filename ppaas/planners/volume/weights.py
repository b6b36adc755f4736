"""Weights of moves in space in fixed point: those of the plane, and √3 for a diagonal over three axes.

The √3 diagonal is rounded to the nearest unit like the √2 one, and weighs more, so `RELATIVE_ERROR` of
`ppaas.planners.weights` also bounds its relative error.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.weights import fixed_weights


def fixed_weights_3d() -> NDArray[np.int64]:
    """Return the (3, 256) weights of moves along one, two and three axes in fixed point; that of 254 is 0."""
    flat = fixed_weights()
    return np.vstack((flat, np.rint(flat[0] * math.sqrt(3.0)).astype(np.int64)))
