"""Kernel: pull the corners of a path of straight lines to where it costs least."""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.grid.kernels.line_of_sight import HAIR, HIDDEN, weigh

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]


@njit(cache=True, nogil=True, error_model="numpy")
def _between(costs: Bytes, stride: Int, weights: Ints, begin: Int, end: Int) -> float:
    row, other = begin // stride, end // stride
    return weigh(costs, stride, weights, begin, other - row, (end - other * stride) - (begin - row * stride))


@njit(cache=True, nogil=True, error_model="numpy")
def _two_lines(costs: Bytes, stride: Int, weights: Ints, begin: Int, corner: Int, end: Int, most: float) -> float:
    """Return what two lines that meet in a corner cost; infinitely much if hidden or no less than ``most``."""
    first = _between(costs, stride, weights, begin, corner)
    if first == HIDDEN or first >= most:
        return np.inf
    second = _between(costs, stride, weights, corner, end)
    return np.inf if second == HIDDEN or first + second >= most else first + second


@njit(cache=True, nogil=True, error_model="numpy")
def _cheaper_beside(
    costs: Bytes, stride: Int, weights: Ints, offsets: Ints, begin: Int, centre: Int, end: Int, most: float
) -> tuple[int, float]:
    """Return the neighbour of a cell that is the best corner between two others, and its cost; −1 for none."""
    best, most = -1, most * (1.0 - HAIR)
    for move in range(8):
        corner = centre + offsets[move]
        if weights[costs[corner]] == 0:
            continue
        cost = _two_lines(costs, stride, weights, begin, corner, end, most)
        if cost < most:
            best, most = corner, cost
    return best, most


@njit(cache=True, nogil=True, error_model="numpy")
def tauten(
    costs: Bytes, stride: int, weights: Ints, offsets: Ints, corners: Ints, count: int, at: int
) -> tuple[int, int]:
    """Improve one corner: leave it out if the straight line costs no more; else move it where that costs less.

    Where one corner cannot be bettered, it and the next may give way to a neighbour of one of them: the lines between
    centres that pass an obstacle closely are often two rows and one column, of which single corners find none.

    Parameters
    ----------
    costs, stride, weights
        As in `ppaas.planners.grid.kernels.line_of_sight.weigh`.
    offsets : (8,) int64 array
        From a cell to its neighbours: where a corner may be moved in one step.
    corners : (m,) int64 array
        Cells; those up to ``count`` are the path.
    count : int
        Corners of the path, both ends included.
    at : int
        Which to improve: neither end.

    Returns
    -------
    count : int
        Corners that are left.
    next : int
        Which to improve next; ``count − 1`` where all are done.
    """
    begin, corner, end = corners[at - 1], corners[at], corners[at + 1]
    now = _two_lines(costs, stride, weights, begin, corner, end, np.inf)
    straight = _between(costs, stride, weights, begin, end)
    left_out = straight != HIDDEN and straight <= now * (1.0 + HAIR)
    if not left_out:
        better, _ = _cheaper_beside(costs, stride, weights, offsets, begin, corner, end, now)
        if better >= 0:
            corners[at] = better
            return count, max(at - 1, 1)
        if at + 2 == count:
            return count, at + 1
        beyond = corners[at + 2]
        now += _between(costs, stride, weights, end, beyond)
        first, least = _cheaper_beside(costs, stride, weights, offsets, begin, corner, beyond, now)
        second, _ = _cheaper_beside(costs, stride, weights, offsets, begin, end, beyond, least)
        if first < 0 and second < 0:
            return count, at + 1
        corners[at + 1] = second if second >= 0 else first
    for later in range(at, count - 1):
        corners[later] = corners[later + 1]
    return count - 1, max(at - 1, 1)


@njit(cache=True, nogil=True, error_model="numpy")
def along(costs: Bytes, stride: int, weights: Ints, corners: Ints, count: int) -> float:
    """Return what a path costs that runs straight from each corner to the next."""
    total = 0.0
    for at in range(count - 1):
        total += _between(costs, stride, weights, corners[at], corners[at + 1])
    return total


def warm() -> None:
    """Compile and call each kernel once."""
    costs, weights, corners = np.zeros(25, np.uint8), np.ones(256, np.int64), np.array([12, 12, 12])
    tauten(costs, 5, weights, np.array([-1, 1, -5, 5, -6, -4, 4, 6]), corners, 3, 1)
    along(costs, 5, weights, corners, 2)
