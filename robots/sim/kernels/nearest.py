"""Kernel: nearest neighbour of each point among the points of an earlier scan, by exhaustive search."""

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True, error_model="numpy")
def nearest(points: NDArray[np.float64], others: NDArray[np.float64], reach: float) -> NDArray[np.int64]:
    """Return for each point the index of its nearest neighbour among others, -1 if none is within ``reach``.

    Parameters
    ----------
    points : (n, k) array
        Points: x, y [m]; further columns are ignored.
    others : (m, k) array
        Candidates, in the same form.
    reach : float
        Greatest distance of a neighbour [m].

    Returns
    -------
    (n,) array
        Indices into ``others``; the first of several at the same distance.
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
    """Compile the kernel or load it from the cache."""
    nearest(np.zeros((1, 4)), np.zeros((1, 4)), 0.1)
