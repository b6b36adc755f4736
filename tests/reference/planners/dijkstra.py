"""Slow, obvious twins of the cost field, of Theta*, and of the queue of tiles.

The cost field is its definition, with a heap and in float64.
"""

import heapq
import itertools
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


class Waiting:
    """Queued tiles with their keys, and the reasons for which they were woken."""

    def __init__(self) -> None:
        self.keys: dict[int, int] = {}
        self.reasons: dict[int, set[int]] = {}
        self.busy: set[int] = set()

    def wake(self, tile: int, key: int, reason: int) -> bool:
        """Queue a tile with a key, or lower its key to it; return whether it was idle."""
        idle = tile not in self.keys and tile not in self.busy
        self.keys[tile] = min(key, self.keys.get(tile, key))
        self.reasons.setdefault(tile, set()).add(reason)
        return idle

    def least(self) -> int | None:
        """Return the least key of the queued tiles that are not being worked on."""
        return min((key for tile, key in self.keys.items() if tile not in self.busy), default=None)

    def take(self, tile: int) -> tuple[int, set[int]]:
        """Take a tile from the queue; return its key and its reasons."""
        self.busy.add(tile)
        return self.keys.pop(tile), self.reasons.pop(tile)

    def let_go(self, tile: int) -> bool:
        """End the work on a tile; return whether it is queued again."""
        self.busy.remove(tile)
        return tile in self.keys
