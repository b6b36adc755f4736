"""``ppaas bench scaling``: how the time of a field grows with the grid."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.planners.grid_arguments import add_threads_argument, check_plot, draw, threads_of
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "the field on grids from 256² up, by number of threads"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_threads_argument(parser)
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the time per cell over the grid size")
    parser.add_argument("--kind", action="append", help="of grid (empty, random 20 %%, maze)")
    parser.add_argument("--largest", type=int, default=8192, metavar="N", help="edge in cells (%(default)s)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Measure grids of all sizes, and draw where that is asked for."""
    from benchmarks.planners import scaling, tables  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    check_plot(arguments)
    kinds = arguments.kind or scaling.KINDS_SHOWN
    told = scaling.measure(kinds, scaling.sizes_up_to(arguments.largest), threads_of(arguments), progress)
    if arguments.plot is not None:
        draw(arguments.plot, scaling.chart(told))
    return Measured(told, tables.scaling_rows(told))
