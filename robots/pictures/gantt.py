"""Gantt charts of time tables: a line for each robot, with its ways and its tasks (extra ``plot``)."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.errors import InvalidInput
from ppaas.tasks.timetable import TimeTableRow
from robots.pictures.figure_file import write_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, LINE = 10.0, 0.45
"""Width of a chart and height of a robot's line [inches, at 100 pixels each]."""

LATE, DONE, WAY = "tab:red", "tab:blue", "0.75"


def write_gantt(path: Path, title: str, rows: Sequence[TimeTableRow]) -> None:
    """Draw a time table and write it to a PNG file.

    Raises
    ------
    InvalidInput
        No robot does a task, the file name does not end with ``.png``, or the file cannot be written.
    """
    if not any(row.robot for row in rows):
        raise InvalidInput("no robot does a task, so there is nothing to draw")
    write_figure(path, draw_gantt(title, rows))


def draw_gantt(title: str, rows: Sequence[TimeTableRow]) -> "Figure":
    """Return the chart: ways to first places in grey, tasks in blue, late ones in red, with the floors of each."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - heavy, and of the extra plot

    robots = sorted({row.robot for row in rows if row.robot})
    figure = Figure(figsize=(WIDTH, 1.2 + LINE * len(robots)), dpi=100, layout="constrained")
    axes = figure.add_subplot(title=title, xlabel="time [s]", ylim=(len(robots) - 0.5, -0.5))
    axes.set_yticks(range(len(robots)), robots)
    end = max((row.finish or 0.0 for row in rows), default=0.0)
    for row in rows:
        if not row.robot or row.set_out is None:
            continue
        line, begin = robots.index(row.robot), end if row.begin is None else row.begin
        finish = end if row.finish is None else row.finish
        axes.barh(line, begin - row.set_out, left=row.set_out, height=0.5, color=WAY)
        axes.barh(line, finish - begin, left=begin, height=0.7, color=LATE if row.late else DONE, edgecolor="white")
        label = f"{row.task}\n{row.floors}" if row.floors else row.task
        axes.text(
            (begin + finish) / 2.0, line, label, ha="center", va="center", color="white", fontsize=8, clip_on=True
        )
    axes.set_xlim(left=0.0)
    axes.grid(axis="x", color="0.9")
    axes.set_axisbelow(True)
    return figure
