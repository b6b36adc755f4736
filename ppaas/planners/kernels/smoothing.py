"""Kernel: the smoothest points near given ones, solved at once instead of step by step."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def relax(points: Floats, near: Floats, even: float, found: Floats) -> None:
    """Find the points y for which near·(x − y) + even·(y before + y after − 2y) is zero.

    These equations are tridiagonal, and solved as such (Thomas' algorithm).

    Parameters
    ----------
    points : (n, 2) array
        The points x.
    near : (n,) array
        How strongly each is drawn to its place: zero or more; infinite if it stays there, as both ends must.
    even : float
        How strongly each is drawn to the two beside it: zero or more; above zero where ``near`` is zero.
    found : (n, 2) array
        Out: the points y.
    """
    count = points.shape[0]
    ratios = np.empty(count)
    for at in range(count):
        ratios[at] = 0.0
        stays = near[at] == np.inf
        pivot = 1.0 if stays else near[at] + 2.0 * even - even * ratios[at - 1]
        if not stays:
            ratios[at] = even / pivot
        for axis in range(2):
            found[at, axis] = points[at, axis]
            if not stays:
                found[at, axis] = (near[at] * points[at, axis] + even * found[at - 1, axis]) / pivot
    for at in range(count - 2, 0, -1):
        for axis in range(2):
            found[at, axis] += ratios[at] * found[at + 1, axis]


def warm() -> None:
    """Compile and call the kernel once."""
    relax(np.zeros((3, 2)), np.array([np.inf, 0.2, np.inf]), 0.3, np.zeros((3, 2)))
