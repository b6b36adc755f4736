"""Kernels: poses in the plane, x, y [m], theta [rad] in (3,) float64 arrays, and their normal equations."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

TINY = 1e-12
"""Least pivot of a Cholesky factor, so that a singular system is solved with a finite step."""


@compiled(inline="always")
def relative(base: NDArray[np.float64], other: NDArray[np.float64], found: NDArray[np.float64]) -> None:
    """Write the pose of ``other`` in the frame at ``base`` to ``found``; its heading is in [−π, π)."""
    c, s = math.cos(base[2]), math.sin(base[2])
    dx, dy = other[0] - base[0], other[1] - base[1]
    found[0], found[1] = c * dx + s * dy, c * dy - s * dx
    found[2] = (other[2] - base[2] + math.pi) % (2.0 * math.pi) - math.pi


@compiled
def solve(sums: NDArray[np.float64]) -> tuple[float, float, float]:
    """Return x of H x = g by Cholesky factorization.

    Parameters
    ----------
    sums : (9,) array
        Upper triangle xx, xy, xt, yy, yt, tt of H, then g.
    """
    a = math.sqrt(max(sums[0], TINY))
    b, c = sums[1] / a, sums[2] / a
    d = math.sqrt(max(sums[3] - b * b, TINY))
    e = (sums[4] - b * c) / d
    f = math.sqrt(max(sums[5] - c * c - e * e, TINY))
    # Forward, then backward substitution.
    x = sums[6] / a
    y = (sums[7] - b * x) / d
    t = (sums[8] - c * x - e * y) / (f * f)
    y = (y - e * t) / d
    return (x - b * y - c * t) / a, y, t
