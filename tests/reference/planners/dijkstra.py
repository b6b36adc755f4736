"""Slow, obvious twins of the cost field: its definition, with a heap and in float64."""

import heapq
import math

import numpy as np
from numpy.typing import NDArray

MOVES = [(dr, dc) for dr in (-1, 0, 1) for dc in (-1, 0, 1) if (dr, dc) != (0, 0)]


def weight(cost: int, allow_unknown: bool) -> float:
    """Return the weight of a cell of this cost; infinite if blocked."""
    if cost == 255:
        return 253.0 if allow_unknown else math.inf
    return 50.0 + 0.8 * cost if cost < 253 else math.inf


def cost_field(
    costs: NDArray[np.uint8], goals: list[tuple[int, int]], allow_unknown: bool = True
) -> NDArray[np.float64]:
    """Return the cost-to-go of each cell."""
    height, width = costs.shape
    weights = [[weight(int(c), allow_unknown) for c in row] for row in costs]
    field = np.full(costs.shape, math.inf)
    queue = []
    for goal in goals:
        field[goal] = 0.0
        queue.append((0.0, goal))
    heapq.heapify(queue)
    while queue:
        value, (row, column) = heapq.heappop(queue)
        if value > field[row, column]:
            continue
        for dr, dc in MOVES:
            r, c = row + dr, column + dc
            if not (0 <= r < height and 0 <= c < width) or math.isinf(weights[r][c]):
                continue
            if math.isinf(weights[r][column]) or math.isinf(weights[row][c]):
                continue
            new = value + weights[r][c] * math.hypot(dr, dc)
            if new < field[r, c]:
                field[r, c] = new
                heapq.heappush(queue, (new, (r, c)))
    return field


def edges(costs: NDArray[np.uint8], allow_unknown: bool = True) -> list[tuple[int, int, float]]:
    """Return all moves as (from, to, weight) for a graph library; cells are flat indices."""
    height, width = costs.shape
    found = []
    for row in range(height):
        for column in range(width):
            for dr, dc in MOVES:
                r, c = row + dr, column + dc
                if not (0 <= r < height and 0 <= c < width):
                    continue
                cells = ((row, column), (r, c), (row, c), (r, column))
                if any(math.isinf(weight(int(costs[cell]), allow_unknown)) for cell in cells):
                    continue
                into = weight(int(costs[r, c]), allow_unknown) * math.hypot(dr, dc)
                found.append((row * width + column, r * width + c, into))
    return found


def fixed_field(costs: NDArray[np.uint8], goals: list[tuple[int, int]], allow_unknown: bool = True) -> list[list[int]]:
    """Return the field in fixed point, 85 units per unit of weight, diagonals rounded; −1 if not reached.

    It is computed by sweeps over all cells until nothing changes (Bellman-Ford).
    """
    height, width = costs.shape
    units = [[weight(int(c), allow_unknown) * 85 for c in row] for row in costs]
    field = [[math.inf] * width for _ in range(height)]
    for row, column in goals:
        field[row][column] = 0
    changed = True
    while changed:
        changed = False
        for r in range(height):
            for c in range(width):
                for dr, dc in MOVES:
                    row, column = r + dr, c + dc
                    if not (0 <= row < height and 0 <= column < width):
                        continue
                    if any(math.isinf(u) for u in (units[r][c], units[row][c], units[r][column])):
                        continue
                    step = round(round(units[r][c]) * math.sqrt(2.0)) if dr and dc else round(units[r][c])
                    if field[row][column] + step < field[r][c]:
                        field[r][c] = field[row][column] + step
                        changed = True
    return [[-1 if math.isinf(value) else int(value) for value in line] for line in field]
