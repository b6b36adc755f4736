"""Results of a bench: figures with baselines and limits, as a table or as JSON."""

import statistics
import sys
from collections.abc import Sequence

import msgspec
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
