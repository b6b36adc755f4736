"""How the time for a cell of the full field depends on the size of the grid and the number of threads."""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

from rich.progress import Progress

from benchmarks.planners.field import grow_anew, reached_once
from benchmarks.planners.grids import KINDS, SEED, Grid, goal_in
from benchmarks.planners.timing import announce, cpus, in_turn, on_threads
from ppaas.errors import InvalidParameter, NotFound
from ppaas.planners.ends import Cell
from robots.pictures.line_chart import Axis, Line

SMALLEST, LARGEST = 256, 8192
FROM = 512
"""Edge from which on the time for a cell is to stay the same; smaller grids fit the processor's caches."""
RUNS, PASSES = 3, 2
"""Of each size in a row, and how often all sizes are gone through: what disturbs a machine for a while then spoils the
figures of no size."""
ALIKE, MOST_ALIKE = 2048, 16
"""Small grids take turns with others of their size, as many as a grid of this edge has room for: a single one would be
learned by heart by the processor, as no robot's map is, and compared with one that is too large for that."""

Told = dict[str, dict[str, float]]
"""``seconds`` and ``ns_per_cell``, by number of threads."""

KINDS_SHOWN = ("empty", "random 20 %", "maze")
"""Of those that there are, where none is asked for."""


class _Alike(NamedTuple):
    """Grids of one kind and size, a goal in each, and how many cells are reached in all of them together."""

    grids: list[Grid]
    goals: list[Cell]
    reached: int


def sizes_up_to(largest: int) -> list[int]:
    """Return 256, 512 … up to ``largest``.

    Raises
    ------
    InvalidParameter
        It is below the smallest.
    """
    if largest < SMALLEST:
        raise InvalidParameter(f"the largest grid has an edge of {SMALLEST} cells or more, not {largest}")
    return [SMALLEST << power for power in range((largest // SMALLEST).bit_length())]


def measure(kinds: Sequence[str], sizes: Sequence[int], threads: Sequence[int], progress: Progress) -> dict[str, Any]:
    """Compute the full field of grids of all sizes.

    Returns
    -------
    dict
        ``sizes`` and, by kind of grid and number of threads, ``seconds`` and ``ns_per_cell``, one number a size, and
        the ``spread``: the most ns a cell over the least, of grids from 512² on where there are any.

    Raises
    ------
    NotFound
        No such kind of grid.
    """
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        raise NotFound("kind of grid", unknown[0], tuple(KINDS))
    told = {
        kind: _of_kind([_alike(kind, size, threads, progress) for size in sizes], threads, progress) for kind in kinds
    }
    by = {
        key: {kind: {str(n): [one[key][str(n)] for one in fields] for n in threads} for kind, fields in told.items()}
        for key in ("seconds", "ns_per_cell")
    }
    spread = {
        kind: {n: _spread(sizes, values) for n, values in by_threads.items()}
        for kind, by_threads in by["ns_per_cell"].items()
    }
    return {"sizes": list(sizes), **by, "spread": spread, "cpus": cpus()}


def _alike(kind: str, size: int, threads: Sequence[int], progress: Progress) -> _Alike:
    announce(progress, f"scaling: making {kind} {size}²")
    grids = [KINDS[kind](size, SEED + number) for number in range(min(MOST_ALIKE, max(1, ALIKE // size) ** 2))]
    goals = [goal_in(grid.costmap) for grid in grids]
    reached = sum(reached_once(grid.costmap, goal, threads) for grid, goal in zip(grids, goals, strict=True))
    return _Alike(grids, goals, reached)


def _of_kind(sizes: Sequence[_Alike], threads: Sequence[int], progress: Progress) -> list[Told]:
    """Return what a field of one of the grids of each size takes in the mean, and for each cell that is reached."""
    passes = [[_of_size(alike, threads, progress) for alike in sizes] for _ in range(PASSES)]
    least = [{n: min(one[n] for one in measured) for n in measured[0]} for measured in zip(*passes, strict=True)]
    return [
        {
            "seconds": {n: seconds / len(alike.grids) for n, seconds in total.items()},
            "ns_per_cell": {n: seconds / alike.reached * 1e9 for n, seconds in total.items()},
        }
        for alike, total in zip(sizes, least, strict=True)
    ]


def _of_size(alike: _Alike, threads: Sequence[int], progress: Progress) -> dict[str, float]:
    """Return the seconds that fields of all these grids take together, by number of threads."""
    name = alike.grids[0].name
    announce(progress, f"scaling: {name}")
    works = {
        f"{n} {number}": partial(grow_anew, grid.costmap, goal, n)
        for n in threads  # one after the other, as a container always has as many: each finds its part in its own cache
        for number, (grid, goal) in enumerate(zip(alike.grids, alike.goals, strict=True))
    }
    best = in_turn(works, progress, name, RUNS)
    return {str(n): sum(best[f"{n} {number}"] for number in range(len(alike.grids))) for n in threads}


def _spread(sizes: Sequence[int], values: Sequence[float]) -> float:
    counted = [value for size, value in zip(sizes, values, strict=True) if size >= FROM] or values
    return max(counted) / min(counted)


def chart(told: dict[str, Any]) -> tuple[str, list[Line], Axis, Axis]:
    """Return what a chart shows of it: a colour a kind of grid, dashes for one thread."""
    lines = [
        Line(
            f"{kind}, {on_threads(n)}",
            list(zip(told["sizes"], values, strict=True)),
            colour=number,
            dashed=n == "1",
        )
        for number, (kind, by_threads) in enumerate(told["ns_per_cell"].items())
        for n, values in by_threads.items()
    ]
    return (
        "Time of the full cost field per reached cell",
        lines,
        Axis("edge length of the square grid [cells], logarithmic", True, told["sizes"]),
        Axis("time per reached cell [ns], logarithmic", True),
    )
