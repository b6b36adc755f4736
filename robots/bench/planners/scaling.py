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
        ``sizes`` and, by kind of grid and number of threads, ``seconds`` and ``ns_per_cell``, one number a size.

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
    return {
        "sizes": list(sizes),
        **{
            key: {
                kind: {str(n): [one[key][str(n)] for one in fields] for n in threads} for kind, fields in told.items()
            }
            for key in ("seconds", "ns_per_cell")
        },
        "cpus": cpus(),
    }


def chart(told: dict[str, Any]) -> tuple[str, list[Line], Axis, Axis]:
    """Return what a chart shows of it."""
    lines = [
        Line(f"{kind}, {n} thread{'s' * (n != '1')}", list(zip(told["sizes"], values, strict=True)))
        for kind, by_threads in told["ns_per_cell"].items()
        for n, values in by_threads.items()
    ]
    return (
        "Full cost field",
        lines,
        Axis("edge of the grid, cells", True, told["sizes"]),
        Axis("ns a cell that is reached", True),
    )
