"""Line charts of measurements, such as an evaluation of planners, drawn by matplotlib (extra ``plot``)."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from robots.pictures.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.axis import Axis as MatplotlibAxis
    from matplotlib.figure import Figure


SIZE = 9.0, 5.6
"""Width and height of a chart [inches, at 100 pixels each]."""

MOST_MARKED = 50
"""Largest number of points of a line that are marked by dots."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Line:
    """A named line through points (x, y).

    Parameters
    ----------
    name : str
        Its name in the legend.
    points : sequence of (float, float)
        At least one.
    colour : int, optional
        Index of the colour; by default each line of a chart has the next one.
    dashed : bool
        Whether the line is dashed.
    """

    name: str
    points: Sequence[Point]
    colour: int | None = None
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class Axis:
    """Label and scale of an axis.

    Parameters
    ----------
    label : str
        Quantity and unit.
    logarithmic : bool
        Whether the scale is logarithmic; all values must then be above 0. A linear scale starts at 0.
    ticks : sequence of float
        Values that are labelled; by default round values.
    """

    label: str
    logarithmic: bool = False
    ticks: Sequence[float] = ()


def write_chart(path: Path, title: str, lines: Sequence[Line], x: Axis, y: Axis) -> None:
    """Draw a chart and write it to a PNG file.

    Raises
    ------
    InvalidInput
        The file name does not end with ``.png``, or the file cannot be written.
    """
    write_figure(path, draw(title, lines, x, y))


def draw(title: str, lines: Sequence[Line], x: Axis, y: Axis) -> "Figure":
    """Return the chart of some lines, with a legend below it."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - heavy, and of the extra plot

    figure = Figure(figsize=SIZE, dpi=100, layout="constrained")
    axes = figure.add_subplot(title=title, xlabel=x.label, ylabel=y.label)
    for number, line in enumerate(lines):
        axes.plot(
            [point[0] for point in line.points],
            [point[1] for point in line.points],
            color=f"C{number if line.colour is None else line.colour}",
            linestyle="--" if line.dashed else "-",
            marker="o" if len(line.points) <= MOST_MARKED else "",
            markersize=4.0,
            label=line.name,
        )
    axes.set(xscale=_scale(x), yscale=_scale(y))
    if not x.logarithmic:
        axes.set_xlim(left=0.0)
    if not y.logarithmic:
        axes.set_ylim(bottom=0.0)
    _set_ticks(axes.xaxis, x)
    _set_ticks(axes.yaxis, y)
    axes.grid(color="0.9")
    axes.set_axisbelow(True)
    figure.legend(handles=axes.lines, loc="outside lower center", ncols=2, frameon=False)
    return figure


def _scale(axis: Axis) -> str:
    return "log" if axis.logarithmic else "linear"


def _set_ticks(drawn: "MatplotlibAxis", axis: Axis) -> None:
    """Label the given values, or 1, 2 and 5 of each decade of a logarithmic axis, with digits instead of powers."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullLocator  # noqa: PLC0415

    if axis.ticks:
        drawn.set_major_locator(FixedLocator(axis.ticks))
    elif axis.logarithmic:
        drawn.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    drawn.set_minor_locator(NullLocator())
    drawn.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,g}"))


# -- chart of an evaluation of planners --------------------------------------------------------------------------------


def write_evaluation(path: Path, evaluation: Mapping[str, Any]) -> None:
    """Draw an evaluation, in the JSON of the REST service, and write the chart to a PNG file.

    Raises
    ------
    InvalidInput
        No path has been computed on the map yet, or the file cannot be written.
    """
    lines = [line for line in map(_line, evaluation["planners"]) if line.points]
    if not lines:
        raise InvalidInput(f"no path was computed on map {evaluation['map']!r} yet, so there is nothing to draw")
    title = f"{evaluation['map']}: computing time of the planners"
    x = Axis("cells between start and goal", logarithmic=True)
    write_chart(path, title, lines, x, Axis("typical time to compute [ms]", logarithmic=True))


def _line(planner: Mapping[str, Any]) -> Line:
    points = [
        (_geometric_mean(*each["cells"]), each["typical_seconds"] * 1e3)
        for each in planner["complexities"]
        if each["typical_seconds"]
    ]
    return Line(f"{planner['planner']}, {planner['queries']} queries{_reuse_rate(planner)}", points)


def _reuse_rate(planner: Mapping[str, Any]) -> str:
    return f", {planner['reuse_rate']:.0%} reused" if planner["reuse_rate"] else ""


def _geometric_mean(first: float, last: float) -> float:
    return math.sqrt(max(first, 0.5) * last)
