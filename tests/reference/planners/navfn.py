"""Slow, obvious twin of navfn's kernels: the same rules, cell by cell, in single precision as in navfn."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Cell = tuple[int, int]
SIDES = ((0, -1), (0, 1), (-1, 0), (1, 0))
F = np.float32


def weight(cost: int, allow_unknown: bool = True) -> int | None:
    """Return the integer weight of a cell of this cost; None if blocked."""
    if cost == 255:
        return 253 if allow_unknown else None
    return min(253, 50 + 8 * cost // 10) if cost < 253 else None


def wave(across: np.float32, along: np.float32, crossing: int) -> np.float32:
    """Return the potential of a cell from those of its lower neighbours on the two axes."""
    low, high = min(across, along), max(across, along)
    if high - low >= crossing:
        return F(low + F(crossing))
    d = F((high - low) / F(crossing))
    bend = F(F(F(F(-0.2301) * d) + F(0.5307)) * d) + F(0.7040)
    return F(low + F(F(crossing) * F(bend)))


def potentials(
    costs: NDArray[np.uint8], goal: Cell, start: Cell | None = None, *, allow_unknown: bool = True, astar: bool = False
) -> NDArray[np.float32]:
    """Return the potentials of all cells, or those computed until the start has one."""
    weights = {cell: weight(int(costs[cell]), allow_unknown) for cell in np.ndindex(costs.shape)}
    found = np.full((costs.shape[0] + 1, costs.shape[1] + 1), np.inf, F)  # index −1 is beyond the map as well
    found[goal] = 0.0
    pull, threshold = _pull(costs.shape, start if astar else None), F(254.0)
    threshold += pull[goal]
    now: list[Cell] = []
    later: list[Cell] = []
    beyond: list[Cell] = []
    for down, right in ((0, 1), (0, -1), (-1, 0), (1, 0)):
        _put((goal[0] + down, goal[1] + right), weights, now, (now,))
    while now and (start is None or np.isinf(found[start])):
        for row, column in now:
            sides = [found[row + down, column + right] for down, right in SIDES]
            fresh = wave(min(sides[:2]), min(sides[2:]), weights[row, column] or 0)
            if fresh < found[row, column]:
                found[row, column] = fresh
                into = later if F(fresh + pull[row, column]) < threshold else beyond
                for (down, right), value in zip(SIDES, sides, strict=True):
                    beside = row + down, column + right
                    if value > F(fresh + F(F(0.707106781) * F(weights.get(beside) or 0))):
                        _put(beside, weights, into, (later, beyond))
        now, later = later, []
        if not now:
            threshold += F(100.0)
            now, beyond = beyond, []
    return found[:-1, :-1]


def _pull(shape: tuple[int, ...], start: Cell | None) -> NDArray[np.float32]:
    """Return the weighted straight distance to the start, for the priority of A*; zeros without a start."""
    if start is None:
        return np.zeros(shape, F)
    rows, columns = np.indices(shape).astype(F)
    return F(50.0) * np.sqrt((rows - F(start[0])) ** 2 + (columns - F(start[1])) ** 2)


def _put(cell: Cell, weights: dict[Cell, int | None], into: list[Cell], waiting: tuple[list[Cell], ...]) -> None:
    if weights.get(cell) is not None and not any(cell in each for each in waiting):
        into.append(cell)


def walk(values: NDArray[np.float32], start: Cell, goal: Cell) -> tuple[list[Cell], list[tuple[float, float]]]:
    """Return the cells and points of the descent, in steps of half a cell or from cell to cell."""

    def of(row: int, column: int) -> float:
        inside = 0 <= row < values.shape[0] and 0 <= column < values.shape[1]
        return float(values[row, column]) if inside else math.inf

    cells, points, place, stay = [start], list[tuple[float, float]](), (float(start[0]), float(start[1])), 0
    while True:
        here = _nearest(place)
        if here != cells[-1]:
            if len(cells) > 1 and _diagonal(of, cells[-2], here):
                cells.pop()
            cells.append(here)
        if here == goal:
            return cells, [*points, (float(goal[0]), float(goal[1]))]
        points.append(place)
        ahead = None
        if stay < 4 and all(of(here[0] + r, here[1] + c) < math.inf for r in (-1, 0, 1) for c in (-1, 0, 1)):
            ahead = _downhill(of, place)
        if ahead is not None and _nearest(ahead) != here and not of(*_nearest(ahead)) < of(*here):
            ahead = None
        if ahead is None:
            row, column = _lowest_neighbour(of, here)
            ahead = float(row), float(column)
        stay = stay + 1 if _nearest(ahead) == here else 0
        place = ahead


def _nearest(place: tuple[float, float]) -> Cell:
    return math.floor(place[0] + 0.5), math.floor(place[1] + 0.5)


def _diagonal(of: Callable[[int, int], float], one: Cell, other: Cell) -> bool:
    apart = abs(one[0] - other[0]), abs(one[1] - other[1])
    return apart == (1, 1) and max(of(one[0], other[1]), of(other[0], one[1])) < math.inf


def _downhill(of: Callable[[int, int], float], place: tuple[float, float]) -> tuple[float, float] | None:
    low_row, low_column = math.floor(place[0]), math.floor(place[1])
    part_row, part_column = place[0] - low_row, place[1] - low_column
    down = right = 0.0
    for r, share_row in ((0, 1.0 - part_row), (1, part_row)):
        for c, share_column in ((0, 1.0 - part_column), (1, part_column)):
            share, row, column = share_row * share_column, low_row + r, low_column + c
            slope = (
                _fall(of(row - 1, column), of(row, column), of(row + 1, column)),
                _fall(of(row, column - 1), of(row, column), of(row, column + 1)),
            )
            if share > 0.0 and math.hypot(*slope) > 0.0:
                down += share * slope[0] / math.hypot(*slope)
                right += share * slope[1] / math.hypot(*slope)
    length = math.hypot(down, right)
    return (place[0] + 0.5 * down / length, place[1] + 0.5 * right / length) if length > 0.0 else None


def _fall(before: float, here: float, after: float) -> float:
    return (before - here if before < math.inf else 0.0) + (here - after if after < math.inf else 0.0)


def _lowest_neighbour(of: Callable[[int, int], float], cell: Cell) -> Cell:
    row, column = cell
    around = [(r, c) for r in (row - 1, row, row + 1) for c in (column - 1, column, column + 1)]
    return min((each for each in around if max(of(each[0], column), of(row, each[1])) < math.inf), key=lambda n: of(*n))
