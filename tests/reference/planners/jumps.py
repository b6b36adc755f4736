"""Slow, obvious twins of the kernels of jump point search and of A*."""

import heapq
import itertools
import math

import numpy as np
from numpy.typing import NDArray

from tests.reference.planners.dijkstra import MOVES, weight

Cell = tuple[int, int]


def units_of(cost: int, allow_unknown: bool) -> int:
    """Return five times the weight of a cell, an integer; 0 if blocked."""
    exact = weight(cost, allow_unknown)
    return round(exact * 5) if math.isfinite(exact) else 0


def unit_values(costs: NDArray[np.uint8], goal: Cell, allow_unknown: bool) -> dict[Cell, int]:
    """Return the cost-to-go of each cell that reaches the goal; a move is 5741 or 8119 times the unit weight."""
    units = {cell: units_of(int(costs[cell]), allow_unknown) for cell in np.ndindex(costs.shape)}
    free = {cell for cell, unit in units.items() if unit}
    values = {goal: 0}
    queue = [(0, goal)]
    while queue:
        value, (row, column) = heapq.heappop(queue)
        if value > values[row, column]:
            continue
        for down, right in MOVES:
            to = row + down, column + right
            if not {to, (to[0], column), (row, to[1])} <= free:
                continue
            new = value + units[to] * (8119 if down and right else 5741)
            if new < values.get(to, math.inf):
                values[to] = new
                heapq.heappush(queue, (new, to))
    return values


def unit_cost(costs: NDArray[np.uint8], cells: NDArray[np.int32], allow_unknown: bool) -> int:
    """Return the cost of a path in the same units; all cells count except the last."""
    total = 0
    for (row, column), (r, c) in itertools.pairwise(cells.tolist()):
        total += units_of(int(costs[row, column]), allow_unknown) * (8119 if row != r and column != c else 5741)
    return total


def kept_neighbours(free: set[Cell], parent: Cell | None) -> set[Cell]:
    """Return the neighbours of (0, 0) to which a path from a neighbour ``parent`` must continue.

    The definition of Harabor and Grastien: a neighbour is pruned if a path within the nine cells that avoids (0, 0) is
    no longer than the one through it, after a straight move, or shorter, after a diagonal move. At the start (None) all
    moves that cut no corner are kept.
    """
    allowed = {(down, right) for down, right in MOVES if {(down, right), (down, 0), (0, right)} <= free | {(0, 0)}}
    if parent is None:
        return allowed
    around = _path_costs(free, parent)
    first = math.hypot(*parent)
    kept = set()
    for to in allowed - {parent}:
        through = first + math.hypot(*to)
        beside = around.get(to, math.inf)
        dropped = beside < through - 1e-9 if all(parent) else beside < through + 1e-9
        if not dropped:
            kept.add(to)
    return kept


def kept_by_weights(weights: dict[Cell, float], parent: Cell) -> set[Cell]:
    """Return the neighbours of (0, 0) to which no path within nine free cells is cheaper than that through (0, 0)."""
    around = _path_costs(set(weights), parent, weights)
    first = math.hypot(*parent) * weights[0, 0]
    return {to for to in MOVES if to != parent and first + math.hypot(*to) * weights[to] < around[to] + 1e-9}


def _path_costs(free: set[Cell], start: Cell, weights: dict[Cell, float] | None = None) -> dict[Cell, float]:
    """Return the costs of the cheapest paths from a cell within the nine around (0, 0) that avoid (0, 0)."""
    lengths = {start: 0.0}
    queue = [(0.0, start)]
    while queue:
        length, (row, column) = heapq.heappop(queue)
        for down, right in MOVES:
            to = row + down, column + right
            if to == (0, 0) or not {to, (to[0], column), (row, to[1])} <= free | {(0, 0)}:
                continue
            new = length + math.hypot(down, right) * (weights[to] if weights else 1.0)
            if new < lengths.get(to, math.inf) - 1e-9:
                lengths[to] = new
                heapq.heappush(queue, (new, to))
    return lengths


def ends_of_jumps(units: NDArray[np.int64]) -> dict[str, NDArray[np.bool_]]:
    """Return the bit planes of a map with these weights; 0 is blocked, as is everything beyond the map."""
    height, width = units.shape

    def at(row: int, column: int) -> int:
        return int(units[row, column]) if 0 <= row < height and 0 <= column < width else 0

    planes = {name: np.zeros(units.shape, np.bool_) for name in ("free", "mixed", "ahead", "back", "square")}
    for row, column in np.ndindex(units.shape):
        around = {at(row + down, column + right) for down in (-1, 0, 1) for right in (-1, 0, 1)} - {0}
        free = at(row, column) > 0
        mixed = free and len(around) > 1
        planes["free"][row, column] = free
        planes["mixed"][row, column] = mixed
        for name, before in (("ahead", column - 1), ("back", column + 1)):
            ended = any(at(side, column) and not at(side, before) for side in (row - 1, row + 1))
            planes[name][row, column] = not free or mixed or ended
        planes["square"][row, column] = all(at(row + down, column + right) for down in (0, 1) for right in (0, 1))
    return planes
