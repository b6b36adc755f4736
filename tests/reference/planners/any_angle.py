"""Slow, obvious twins of Theta*: the cells on a line, and the cheapest path of lines."""

import heapq
import itertools
import math

import numpy as np
from numpy.typing import NDArray

from tests.reference.planners.dijkstra import weight

Cell = tuple[int, int]


def crossed(begin: Cell, end: Cell) -> tuple[list[tuple[Cell, float]], list[Cell]]:
    """Return the cells on a line between two centres with their shares of it, and the cells that it only touches.

    The crossings of cell borders are computed in integers; between two crossings the line is in one cell.
    """
    down, right = end[0] - begin[0], end[1] - begin[1]
    rows, columns = max(abs(down), 1), max(abs(right), 1)
    whole = 2 * rows * columns
    across = {(2 * i - 1) * columns for i in range(1, abs(down) + 1)}
    along = {(2 * i - 1) * rows for i in range(1, abs(right) + 1)}
    inside, touched = [], []
    for first, last in itertools.pairwise(sorted({0, whole} | across | along)):
        cell = tuple(
            (2 * whole * at + whole + step * (first + last)) // (2 * whole)
            for at, step in zip(begin, (down, right), strict=True)
        )
        if first in across & along:
            before = inside[-1][0]
            touched += [(before[0], cell[1]), (cell[0], before[1])]
        inside.append((cell, (last - first) / whole))
    return inside, touched


def line(costs: NDArray[np.uint8], begin: Cell, end: Cell, allow_unknown: bool = True) -> float:
    """Return the integral of the weights along a line; infinite if it meets a blocked cell."""
    inside, touched = crossed(begin, end)
    met = [cell for cell, _ in inside] + touched
    if any(math.isinf(weight(int(costs[cell]), allow_unknown)) for cell in met):
        return math.inf
    return math.dist(begin, end) * sum(weight(int(costs[cell]), allow_unknown) * share for cell, share in inside)


def cheapest(costs: NDArray[np.uint8], start: Cell, goal: Cell, allow_unknown: bool = True) -> float:
    """Return the cost of the cheapest path of lines between cells, by trying all lines."""
    best = {start: 0.0}
    queue = [(0.0, start)]
    done: set[Cell] = set()
    while queue:
        cost, cell = heapq.heappop(queue)
        if cell == goal:
            return cost
        if cell in done:
            continue
        done.add(cell)
        for other in np.ndindex(costs.shape):
            reached = cost + line(costs, cell, other, allow_unknown) if other not in done else math.inf
            if reached < best.get(other, math.inf):
                best[other] = reached
                heapq.heappush(queue, (reached, other))
    return math.inf
