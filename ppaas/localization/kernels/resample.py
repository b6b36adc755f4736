"""Kernels: resampling of particles by their weights, and the number of particles needed (KLD sampling)."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.localization.kernels.bins import bin_of, empty_table, slot_of


@compiled
def draw_low_variance(weights: NDArray[np.float64], count: int, start: float) -> NDArray[np.int64]:
    """Return particles drawn by low variance sampling (*Probabilistic Robotics*, table 4.4).

    Parameters
    ----------
    weights : (n,) array
        Weights, at least 0, with sum 1.
    count : int
        Number of particles to draw.
    start : float
        Random number from [0, 1).

    Returns
    -------
    (count,) int array
        Indices of the particles drawn, in ascending order.
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


@compiled
def kld_limit(bins: int, error: float, z: float) -> float:
    """Return the number of particles for a Kullback-Leibler distance below ``error`` with ``bins`` bins occupied.

    Fox, *KLD-Sampling: Adaptive Particle Filters* (2001), equation 7; as in amcl, ``z`` is the quantile itself.
    """
    k = max(bins - 1, 1)
    a = 2.0 / (9.0 * k)
    return k / (2.0 * error) * (1.0 - a + math.sqrt(a) * z) ** 3


@compiled
def _starts(cumulative: NDArray[np.float64], total: float) -> NDArray[np.int64]:
    """Return for each of n equal parts of the total weight the first particle to examine (index of cumulative sums)."""
    count = cumulative.size
    starts = np.empty(count, np.int64)
    i = 0
    for part in range(count):
        while i < count - 1 and cumulative[i] < part * total / count:
            i += 1
        starts[part] = i
    return starts


@compiled
def kld_sample_size(
    particles: NDArray[np.float64],
    weights: NDArray[np.float64],
    picks: NDArray[np.float64],
    least: int,
    error: float,
    z: float,
) -> int:
    """Return the number of particles by KLD sampling (*Probabilistic Robotics*, table 8.4).

    Particles are drawn one by one until there are enough for the number of bins that they occupy.

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
        Weights, at least 0 and not all 0.
    picks : (most,) array
        Random numbers from [0, 1), one for each draw.
    least : int
        Smallest result; the largest is ``most``.
    error, z : float
        See `kld_limit`.
    """
    cumulative = np.cumsum(weights)
    total, count = cumulative[-1], cumulative.size
    starts = _starts(cumulative, total)
    table = empty_table(picks.size)
    bins = 0
    limit = float(least)
    for drawn in range(picks.size):
        if drawn >= limit:
            return drawn
        # Draw by inverse transform sampling, starting from the index of cumulative sums.
        i = starts[min(int(picks[drawn] * count), count - 1)]
        while i < count - 1 and cumulative[i] <= picks[drawn] * total:
            i += 1
        # A newly occupied bin raises the limit.
        key = bin_of(particles[i, 0], particles[i, 1], particles[i, 2])
        slot = slot_of(table, key)
        if table[slot] != key:
            table[slot] = key
            bins += 1
            limit = max(kld_limit(bins, error, z), float(least))
    return picks.size


def warm() -> None:
    """Call each kernel once, so that it is compiled or loaded from the cache."""
    draw_low_variance(np.ones(1), 1, 0.5)
    kld_sample_size(np.zeros((1, 3)), np.ones(1), np.zeros(1), 1, 0.01, 0.99)
