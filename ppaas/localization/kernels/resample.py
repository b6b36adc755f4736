"""Drawing particles by their weights, and how many."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.localization.kernels.bins import bin_of, empty_table, slot_of


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


@njit(cache=True, nogil=True, error_model="numpy")
def kld_limit(bins: int, error: float, z: float) -> float:
    """Return how many particles keep the Kullback-Leibler distance under ``error``, by the bins that are filled.

    Fox, *KLD-Sampling: Adaptive Particle Filters* (2001), equation 7; ``z`` is the quantile itself, as amcl has it.
    """
    k = max(bins - 1, 1)
    a = 2.0 / (9.0 * k)
    return k / (2.0 * error) * (1.0 - a + math.sqrt(a) * z) ** 3


@njit(cache=True, nogil=True, error_model="numpy")
def _starts(cumulative: NDArray[np.float64], total: float) -> NDArray[np.int64]:
    """Return from which particle on to look for a part of the total weight, by n parts of equal size."""
    count = cumulative.size
    starts = np.empty(count, np.int64)
    i = 0
    for part in range(count):
        while i < count - 1 and cumulative[i] < part * total / count:
            i += 1
        starts[part] = i
    return starts


@njit(cache=True, nogil=True, error_model="numpy")
def enough(
    particles: NDArray[np.float64],
    weights: NDArray[np.float64],
    picks: NDArray[np.float64],
    least: int,
    error: float,
    z: float,
) -> int:
    """Return how many particles do: drawn one by one until they are enough for the bins that they fill (KLD).

    Parameters
    ----------
    particles : (n, 3) array
        x, y [m], theta [rad].
    weights : (n,) array
        Not negative, and not all 0.
    picks : (most,) array
        Random numbers from [0, 1), one for each that may be drawn.
    least : int
        The result is no less, and no more than ``most``.
    error, z : float
        As `kld_limit` has them.
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
        i = starts[min(int(picks[drawn] * count), count - 1)]
        while i < count - 1 and cumulative[i] <= picks[drawn] * total:
            i += 1
        key = bin_of(particles[i, 0], particles[i, 1], particles[i, 2])
        slot = slot_of(table, key)
        if table[slot] != key:
            table[slot] = key
            bins += 1
            limit = max(kld_limit(bins, error, z), float(least))
    return picks.size


def warm() -> None:
    """Compile, or load what was compiled."""
    draw_low_variance(np.ones(1), 1, 0.5)
    enough(np.zeros((1, 3)), np.ones(1), np.zeros(1), 1, 0.01, 0.99)
