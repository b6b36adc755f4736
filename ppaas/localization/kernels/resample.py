"""Drawing particles by their weights."""

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True, error_model="numpy")
def draw_low_variance(weights: NDArray[np.float64], count: int, start: float) -> NDArray[np.int64]:
    """Draw particles with one random number and equal steps (*Probabilistic Robotics*, table 4.4).

    Parameters
    ----------
    weights : (n,) array
        Not negative, with a sum of 1.
    count : int
        How many to draw.
    start : float
        Random number from [0, 1).

    Returns
    -------
    (count,) int array
        Indices, ascending.
    """
    drawn = np.empty(count, dtype=np.int64)
    last = weights.shape[0] - 1
    i = 0
    reached = weights[0]
    for k in range(count):
        pointer = (k + start) / count
        while pointer >= reached and i < last:
            i += 1
            reached += weights[i]
        drawn[k] = i
    return drawn


def warm() -> None:
    """Compile, or load what was compiled."""
    draw_low_variance(np.ones(1), 1, 0.5)
