"""What moves in space weigh in fixed point: those of the plane, and √3 for a diagonal through a corner.

It is rounded to the nearest unit as the other diagonal is, and weighs more; so `RELATIVE_ERROR` of
`ppaas.planners.weights` bounds its error as well.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.weights import fixed_weights


def fixed_weights_3d() -> NDArray[np.int64]:
    """Return the (3, 256) weights of moves along one, two and three axes in fixed point; 254 has none and reads 0."""
    flat = fixed_weights()
    return np.vstack((flat, np.rint(flat[0] * math.sqrt(3.0)).astype(np.int64)))
