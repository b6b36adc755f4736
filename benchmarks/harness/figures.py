"""Results of a bench: figures with baselines and limits, of samples and of parts, as a table or as JSON."""

import itertools
import statistics
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import msgspec
import numpy as np
from rich.console import Console
from rich.table import Table

from robots.cli.benches import Measured

WIDTH = 160
"""Width of a table that is not printed on a terminal [characters]."""


class Figure(msgspec.Struct, frozen=True, omit_defaults=True):
    """One measured quantity.

    Parameters
    ----------
    part : str
        Part of the bench.
    name : str
        Name of the quantity.
    value : float
        Median of the samples, in ``unit``.
    unit : str
    least, most : float, optional
        Smallest and largest sample.
    limit : float, optional
        Largest acceptable value.
    floor : bool
        Whether ``limit`` is the smallest acceptable value instead.
    yardstick : bool
        Whether this is a baseline: another implementation, measured in the same run.
    note : str
        How the value was obtained.
    """

    part: str
    name: str
    value: float
    unit: str
    least: float | None = None
    most: float | None = None
    limit: float | None = None
    floor: bool = False
    yardstick: bool = False
    note: str = ""

    @property
    def kept(self) -> bool | None:
        """Whether the value is within the limit; None without a limit."""
        if self.limit is None:
            return None
        return self.value >= self.limit if self.floor else self.value <= self.limit


def median_of(part: str, name: str, samples: Sequence[float], unit: str = "ms", *, limit: float | None = None,
              yardstick: bool = False, note: str = "") -> Figure:  # fmt: skip
    """Return the median of samples with their spread; samples are in seconds if ``unit`` is ``ms``."""
    scale = 1e3 if unit == "ms" else 1.0
    middle, least, most = (scale * f(samples) for f in (statistics.median, min, max))
    return Figure(
        part, name, round(middle, 3), unit, round(least, 3), round(most, 3), limit, yardstick=yardstick, note=note
    )


def measured(figures: Sequence[Figure]) -> Measured:
    """Return figures as the result of a bench; in the table, baselines are dim."""
    console = Console(width=None if sys.stdout.isatty() else WIDTH)
    with console.capture() as captured:
        console.print(_table(figures))
    return Measured(msgspec.to_builtins({"figures": figures}), text=captured.get().removesuffix("\n"))


def _table(figures: Sequence[Figure]) -> Table:
    table = Table(title="ppaas bench", title_justify="left")
    for column, justify in (("part", "left"), ("measured", "left"), ("median", "right"), ("least–most", "right"),
                            ("limit", "right"), ("met", "left"), ("what it is made of", "left")):  # fmt: skip
        table.add_column(column, justify=justify)  # type: ignore[arg-type]
    for figure in figures:
        table.add_row(*_cells(figure), style="dim" if figure.yardstick else None)
    return table


def _cells(figure: Figure) -> tuple[str, ...]:
    spread = "" if figure.least is None else f"{figure.least:,.4g}–{figure.most:,.4g}"
    limit = "" if figure.limit is None else f"{'≥' if figure.floor else '≤'} {figure.limit:g}"
    colour = {None: "", True: "[green]", False: "[red]"}[figure.kept]
    value = f"{colour}{figure.value:,.4g} {figure.unit}".rstrip()
    met = {None: "", True: "yes", False: "NO"}[figure.kept]
    return figure.part, figure.name, value, spread, limit, met, figure.note


# -- figures of samples ------------------------------------------------------------------------------------------------


def median_and_p99(
    part: str, name: str, samples: Sequence[float], *, limit: float | None = None, note: str = ""
) -> list[Figure]:
    """Return the median and the 99th percentile of samples [s], both with the limit [ms]."""
    p99 = float(np.percentile(samples, 99, method="higher"))
    return [
        median_of(part, name, samples, limit=limit, note=note),
        Figure(part, f"{name}, p99", round(1e3 * p99, 3), "ms", limit=limit, note=f"of {len(samples)}"),
    ]


def median_and_worst(
    part: str, name: str, samples: Sequence[float], *, limit: float | None, note: str = ""
) -> list[Figure]:
    """Return the median and the maximum of samples [s], both with the limit, if any [ms]."""
    return [
        median_of(part, name, samples, limit=limit, note=note),
        Figure(part, f"{name}, worst", round(1e3 * max(samples), 3), "ms", limit=limit, note=f"of {len(samples)}"),
    ]


def served_after(commands: Sequence[float], fault: float) -> float:
    """Return the time from a fault until a robot received commands again [s].

    Commands in flight still arrive after the fault, so the effect of the fault is the longest gap that ends after it.

    Parameters
    ----------
    commands : sequence of float
        Arrival times in order [s], at least one of them before and one after the fault.
    fault : float
        Time of the fault [s].
    """
    ends = [(after - before, after) for before, after in itertools.pairwise(commands) if after > fault]
    return max(ends)[1] - fault


# -- options of a bench that has several parts, and their results ------------------------------------------------------


@dataclass(frozen=True, slots=True)
class PartSelection:
    """Parts to measure, and the number of samples.

    Parameters
    ----------
    only : tuple of str
        Names of parts; empty for all.
    quick : bool
        Whether to take few samples.
    """

    only: tuple[str, ...] = ()
    quick: bool = False

    def wants(self, part: str) -> bool:
        """Return whether a part is to be measured."""
        return not self.only or part in self.only


class PartResult(NamedTuple):
    """Result of a part.

    Parameters
    ----------
    figures : list of Figure
        Quantities that have bars, and baselines.
    rows : list of dict
        Details for people; all rows have the same keys.
    results : list of dict
        Complete results for programs.
    """

    figures: list[Figure]
    rows: list[dict[str, str]]
    results: list[dict[str, Any]]

    @classmethod
    def failed(cls, part: str, error: Exception) -> "PartResult":
        """Return a figure that misses its bar, with the reason."""
        return cls([Figure(part, "measured", 0, "", limit=1.0, floor=True, note=str(error))], [], [])
