"""Bench of scaling: time per cell of the full cost field, by size of the grid and number of threads."""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

from rich.progress import Progress

from benchmarks.planners.field import grow_uncached, warm_up
from benchmarks.planners.grids import KINDS, SEED, Grid, check_kinds, goal_in
from benchmarks.planners.timing import announce, cpus, in_turn, on_threads
from ppaas.errors import InvalidParameter
from ppaas.planners.ends import Cell
from robots.pictures.line_chart import Axis, Line

SMALLEST, LARGEST = 256, 8192
"""Smallest and largest edge [cells]."""
FROM = 512
"""Edge from which the time per cell should stay constant [cells]; smaller grids fit the processor's caches."""
RUNS, PASSES = 3, 2
"""Number of consecutive runs of a size, and of passes over all sizes: a temporary disturbance then affects no size in
all of its runs."""
SAME_SIZE_EDGE, MOST_OF_A_SIZE = 2048, 16
"""Small grids take turns with others of their size, as many as fit a grid of this edge [cells], and at most this many:
the branch predictor and the caches would adapt to a single small grid, but not to a large one."""

Told = dict[str, dict[str, float]]
"""``seconds`` and ``ns_per_cell``, by number of threads."""

KINDS_SHOWN = ("empty", "random 20 %", "maze")
"""Kinds of grids that are measured by default."""


class _SameSize(NamedTuple):
    """Grids of one kind and size, a goal in each, and the total number of reached cells."""

    grids: list[Grid]
    goals: list[Cell]
    reached: int


def sizes_up_to(largest: int) -> list[int]:
    """Return the edges 256, 512 … up to ``largest`` [cells].

    Raises
    ------
    InvalidParameter
        ``largest`` is below the smallest edge.
    """
    if largest < SMALLEST:
        raise InvalidParameter(f"the largest edge must be {SMALLEST} cells or more, not {largest}")
    return [SMALLEST << power for power in range((largest // SMALLEST).bit_length())]


def measure(kinds: Sequence[str], sizes: Sequence[int], threads: Sequence[int], progress: Progress) -> dict[str, Any]:
    """Compute the full field of grids of all sizes.

    Returns
    -------
    dict
        ``sizes`` and, by kind of grid and number of threads, ``seconds`` and ``ns_per_cell``, one number for each size,
        and the ``spread``: the ratio of the largest to the smallest time per cell, of grids from 512² on if there are
        any.

    Raises
    ------
    NotFound
        A kind of grid is unknown.
    """
    check_kinds(kinds)
    told = {
        kind: _of_kind([_same_size(kind, size, threads, progress) for size in sizes], threads, progress)
        for kind in kinds
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


def _same_size(kind: str, size: int, threads: Sequence[int], progress: Progress) -> _SameSize:
    announce(progress, f"scaling: making {kind} {size}²")
    grids = [
        KINDS[kind](size, SEED + number) for number in range(min(MOST_OF_A_SIZE, max(1, SAME_SIZE_EDGE // size) ** 2))
    ]
    goals = [goal_in(grid.costmap) for grid in grids]
    reached = sum(warm_up(grid.costmap, goal, threads) for grid, goal in zip(grids, goals, strict=True))
    return _SameSize(grids, goals, reached)


def _of_kind(sizes: Sequence[_SameSize], threads: Sequence[int], progress: Progress) -> list[Told]:
    """Return the mean time of a field of each size [s], and the time per reached cell [ns]."""
    passes = [[_of_size(same_size, threads, progress) for same_size in sizes] for _ in range(PASSES)]
    least = [{n: min(one[n] for one in measured) for n in measured[0]} for measured in zip(*passes, strict=True)]
    return [
        {
            "seconds": {n: seconds / len(same_size.grids) for n, seconds in total.items()},
            "ns_per_cell": {n: seconds / same_size.reached * 1e9 for n, seconds in total.items()},
        }
        for same_size, total in zip(sizes, least, strict=True)
    ]


def _of_size(same_size: _SameSize, threads: Sequence[int], progress: Progress) -> dict[str, float]:
    """Return the total time of the fields of all grids [s], by number of threads."""
    name = same_size.grids[0].name
    announce(progress, f"scaling: {name}")
    works = {
        f"{n} {number}": partial(grow_uncached, grid.costmap, goal, n)
        for n in threads  # not in turn: a container always has the same number, so each thread finds its part cached
        for number, (grid, goal) in enumerate(zip(same_size.grids, same_size.goals, strict=True))
    }
    best = in_turn(works, progress, name, RUNS)
    return {str(n): sum(best[f"{n} {number}"] for number in range(len(same_size.grids))) for n in threads}


def _spread(sizes: Sequence[int], values: Sequence[float]) -> float:
    counted = [value for size, value in zip(sizes, values, strict=True) if size >= FROM] or values
    return max(counted) / min(counted)


def chart(told: dict[str, Any]) -> tuple[str, list[Line], Axis, Axis]:
    """Return title, lines and axes of the chart: a colour for each kind of grid, dashed lines for one thread."""
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
