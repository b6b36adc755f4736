"""How the time for a cell of the full field depends on the size of the grid and the number of threads."""

from collections.abc import Sequence
from typing import Any

from rich.progress import Progress

from ppaas.errors import InvalidParameter, NotFound
from robots.bench.planners import field
from robots.bench.planners.chart import Axis, Line
from robots.bench.planners.grids import KINDS
from robots.bench.planners.timing import cpus

SMALLEST, LARGEST = 256, 8192
FROM = 512
"""Edge from which on the time for a cell is to stay the same; smaller grids fit the processor's caches."""
RUNS = 3

KINDS_SHOWN = ("empty", "random 20 %", "maze")
"""Of those that there are, where none is asked for."""


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
        kind: [field.measure(KINDS[kind](size), None, threads, progress, runs=RUNS) for size in sizes] for kind in kinds
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


def _spread(sizes: Sequence[int], values: Sequence[float]) -> float:
    counted = [value for size, value in zip(sizes, values, strict=True) if size >= FROM] or values
    return max(counted) / min(counted)


def chart(told: dict[str, Any]) -> tuple[str, list[Line], Axis, Axis]:
    """Return what a chart shows of it: a colour a kind of grid, dashes for one thread."""
    lines = [
        Line(
            f"{kind}, {n} thread{'s' * (n != '1')}",
            list(zip(told["sizes"], values, strict=True)),
            colour=number,
            dashed=n == "1",
        )
        for number, (kind, by_threads) in enumerate(told["ns_per_cell"].items())
        for n, values in by_threads.items()
    ]
    return (
        "Time of the full field of costs, for each cell that is reached",
        lines,
        Axis("edge of the square grid, cells (logarithmic)", True, told["sizes"]),
        Axis("ns a cell (logarithmic)", True),
    )
