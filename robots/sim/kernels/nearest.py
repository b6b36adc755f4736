"""Kernel: which of the points that were seen before is the nearest to each that is seen now."""

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True, error_model="numpy")
def nearest(points: NDArray[np.float64], others: NDArray[np.float64], reach: float) -> NDArray[np.int64]:
    """Return for each point the index of the nearest of some others, -1 where none is within ``reach`` [m].

    Parameters
    ----------
    points : (n, k) array
        x, y, and what else a row tells [m].
    others : (m, k) array
        Likewise.
    reach : float
        [m].

    Returns
    -------
    (n,) array
        Of two that are as near, the first.
    """
    found = np.full(len(points), -1, np.int64)
    for i in range(len(points)):
        x, y, least = points[i, 0], points[i, 1], reach * reach
        for j in range(len(others)):
            dx = others[j, 0] - x
            square = dx * dx + (others[j, 1] - y) ** 2
            if square < least or (found[i] < 0 and square == least):
                least, found[i] = square, j
    return found


def warm() -> None:
    """Compile, or load what was compiled."""
    nearest(np.zeros((1, 4)), np.zeros((1, 4)), 0.1)
