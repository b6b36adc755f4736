"""Kernel: smooth points near given ones, by a direct solution instead of an iteration."""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Floats = NDArray[np.float64]


@compiled
def relax(points: Floats, near: Floats, even: float, found: Floats) -> None:
    """Solve near·(x − y) + even·(y[i − 1] + y[i + 1] − 2y) = 0 for the points y.

    The system is tridiagonal, and solved by Thomas' algorithm.

    Parameters
    ----------
    points : (n, 2) array
        The points x.
    near : (n,) array
        Data weight of each point, at least 0; infinite for fixed points, which both ends must be.
    even : float
        Smoothness weight, at least 0; above 0 if a ``near`` is 0.
    found : (n, 2) array
        Out: the points y.
    """
    count = points.shape[0]
    ratios = np.empty(count)
    # Forward elimination.
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
    # Back substitution.
    for at in range(count - 2, 0, -1):
        for axis in range(2):
            found[at, axis] += ratios[at] * found[at + 1, axis]


def warm() -> None:
    """Compile and call the kernel once."""
    relax(np.zeros((3, 2)), np.array([np.inf, 0.2, np.inf]), 0.3, np.zeros((3, 2)))
