"""Kernel: string pulling, which moves and removes corners of a path of straight lines to lower its cost."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.grid.kernels.line_of_sight import HAIR, HIDDEN, weigh

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]


@compiled
def _between(costs: Bytes, stride: Int, weights: Ints, begin: Int, end: Int) -> float:
    row, other = begin // stride, end // stride
    return weigh(costs, stride, weights, begin, other - row, (end - other * stride) - (begin - row * stride))


@compiled
def _two_lines(costs: Bytes, stride: Int, weights: Ints, begin: Int, corner: Int, end: Int, most: float) -> float:
    """Return the cost of two lines that meet in a corner; infinite if one is hidden, or from ``most`` on."""
    first = _between(costs, stride, weights, begin, corner)
    if first == HIDDEN or first >= most:
        return np.inf
    second = _between(costs, stride, weights, corner, end)
    return np.inf if second == HIDDEN or first + second >= most else first + second


@compiled
def _cheaper_beside(
    costs: Bytes, stride: Int, weights: Ints, offsets: Ints, begin: Int, centre: Int, end: Int, most: float
) -> tuple[int, float]:
    """Return the neighbour of ``centre`` that is the cheapest corner, and its cost; −1 if none is below ``most``."""
    best, most = -1, most * (1.0 - HAIR)
    for move in range(8):
        corner = centre + offsets[move]
        if weights[costs[corner]] == 0:
            continue
        cost = _two_lines(costs, stride, weights, begin, corner, end, most)
        if cost < most:
            best, most = corner, cost
    return best, most


@compiled
def tauten(
    costs: Bytes, stride: int, weights: Ints, offsets: Ints, corners: Ints, count: int, at: int
) -> tuple[int, int]:
    """Improve one corner: remove it if the straight line costs no more; else move it to a cheaper neighbour.

    If a corner cannot be improved, the kernel tries to replace it and the next one by a neighbour of either. Close to
    obstacles this finds improvements that need two corners to change at once.

    Parameters
    ----------
    costs, stride, weights
        As in `ppaas.planners.grid.kernels.line_of_sight.weigh`.
    offsets : (8,) int64 array
        Offsets of the neighbours of a cell: the moves of a corner in one step.
    corners : (m,) int64 array
        Cells of the corners; the first ``count`` are the path. In and out.
    count : int
        Number of corners, including both ends.
    at : int
        Index of the corner to improve; neither end.

    Returns
    -------
    count : int
        Number of corners that are left.
    next : int
        Index of the corner to improve next; ``count − 1`` if all are done.
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


@compiled
def along(costs: Bytes, stride: int, weights: Ints, corners: Ints, count: int) -> float:
    """Return the cost of a path that runs straight from each corner to the next."""
    total = 0.0
    for at in range(count - 1):
        total += _between(costs, stride, weights, corners[at], corners[at + 1])
    return total


def warm() -> None:
    """Compile and call each kernel once."""
    costs, weights, corners = np.zeros(25, np.uint8), np.ones(256, np.int64), np.array([12, 12, 12])
    tauten(costs, 5, weights, np.array([-1, 1, -5, 5, -6, -4, 4, 6]), corners, 3, 1)
    along(costs, 5, weights, corners, 2)
