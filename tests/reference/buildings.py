"""Slow, obvious twin of the planner over floors: Dijkstra's algorithm over all cells of all floors at once."""

import heapq
import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

Spot = tuple[int, int, int]
"""Floor, row, column."""

Jump = tuple[Spot, Spot, float, str]
"""Move from one cell to another that is not driven: its time [s] and its name."""

_MOVES = [(down, right) for down in (-1, 0, 1) for right in (-1, 0, 1) if (down, right) != (0, 0)]


def times_from(
    floors: Sequence[NDArray[np.bool_]], jumps: Iterable[Jump], sources: dict[Spot, float], cell_seconds: float
) -> dict[Spot, float]:
    """Return the least time at which each cell is reached from cells that are reached at given times [s].

    Parameters
    ----------
    floors : sequence of (height, width) bool array
        Free cells.
    jumps : iterable of Jump
    sources : dict
    cell_seconds : float
        Time of a straight move [s].
    """
    taken: dict[Spot, list[tuple[Spot, float]]] = {}
    for start, goal, seconds, _ in jumps:
        taken.setdefault(start, []).append((goal, seconds))
    times: dict[Spot, float] = {}
    queue = [(seconds, spot) for spot, seconds in sources.items() if floors[spot[0]][spot[1:]]]
    heapq.heapify(queue)
    while queue:
        seconds, spot = heapq.heappop(queue)
        if spot in times:
            continue
        times[spot] = seconds
        for goal, more in [*_driven(floors, spot, cell_seconds), *taken.get(spot, [])]:
            if goal not in times:
                heapq.heappush(queue, (seconds + more, goal))
    return times


def best_by_names(
    floors: Sequence[NDArray[np.bool_]], jumps: Sequence[Jump], start: Spot, goal: Spot, cell_seconds: float
) -> dict[tuple[str, ...], float]:
    """Return the least time for each sequence of different lifts and ways that leads to the goal [s].

    Jumps without a name, through doors, may be taken between at any time.
    """
    names = sorted({name for *_, name in jumps if name})
    doors = [jump for jump in jumps if not jump[3]]
    found: dict[tuple[str, ...], float] = {}

    def go_on(sequence: tuple[str, ...], reached: dict[Spot, float]) -> None:
        if goal in reached:
            found[sequence] = reached[goal]
        for name in names:
            after: dict[Spot, float] = {}
            for one, other, seconds, of in jumps if name not in sequence else ():
                if of == name and one in reached:
                    after[other] = min(after.get(other, math.inf), reached[one] + seconds)
            if after:
                go_on((*sequence, name), times_from(floors, doors, after, cell_seconds))

    go_on((), times_from(floors, doors, {start: 0.0}, cell_seconds))
    return found


def _driven(floors: Sequence[NDArray[np.bool_]], spot: Spot, cell_seconds: float) -> list[tuple[Spot, float]]:
    floor, row, column = spot
    free = floors[floor]

    def is_free(r: int, c: int) -> bool:
        return 0 <= r < free.shape[0] and 0 <= c < free.shape[1] and bool(free[r, c])

    moves = []
    for down, right in _MOVES:
        beside = is_free(row + down, column) and is_free(row, column + right)
        if is_free(row + down, column + right) and beside:
            moves.append(((floor, row + down, column + right), cell_seconds * math.hypot(down, right)))
    return moves
