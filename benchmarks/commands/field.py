"""``ppaas bench field``: time of the full cost field of a goal on one grid."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.planners.grid_arguments import (
    add_goal_argument,
    add_grid_arguments,
    add_threads_argument,
    check_plot,
    draw,
    goal_of,
    grid_of,
    tell_left_out,
    threads_of,
)
from ppaas.errors import InvalidParameter
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "the full cost field of one goal"

LONGEST_PAUSE = 60.0
"""Longest pause between two fields [s]."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_grid_arguments(parser)
    add_goal_argument(parser)
    add_threads_argument(parser)
    parser.add_argument("--plot", type=Path, metavar="OUT.png",
                        help="draw the planning time over the path length, by number of threads")  # fmt: skip
    parser.add_argument(
        "--beside",
        type=_names,
        default=[],
        metavar="A,B",
        help="implementations to compare with: navfn, or packages from PyPI",
    )
    parser.add_argument(
        "--pause", type=_pause, metavar="S", help="also measure fields with this pause [s] between them"
    )


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Measure, and draw the chart if it is requested."""
    from benchmarks.planners import field, path_lengths, tables  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.planners.peers import beside  # noqa: PLC0415

    check_plot(arguments)
    grid, threads = grid_of(arguments), threads_of(arguments)
    others = beside(arguments.beside)
    told = field.measure(grid, goal_of(arguments), threads, progress, others=others)
    tell_left_out(told, progress)
    if arguments.pause is not None:
        told["paused_seconds"] = field.with_pauses(grid, tuple(told["goal"]), threads, arguments.pause, progress)
    if arguments.plot is not None:
        lengths = event_loop.run(path_lengths.measure_locally(grid.costmap, threads, progress))
        draw(arguments.plot, path_lengths.chart(lengths))
    return Measured(told, tables.field_rows(told))


def _pause(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 <= seconds <= LONGEST_PAUSE:
        raise InvalidParameter(f"--pause must be 0 to {LONGEST_PAUSE:g} seconds, not {text!r}")
    return seconds


def _names(text: str) -> list[str]:
    return list(dict.fromkeys(text.split(",")))
