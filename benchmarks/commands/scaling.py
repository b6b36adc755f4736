"""``ppaas bench scaling``: time of the full cost field, or of plans, by size of the grid."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.planners.grid_arguments import add_threads_argument, check_plot, draw, threads_of
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "the full cost field, or plans, on grids from 256² up"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_threads_argument(parser)
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the time per cell over the grid size")
    parser.add_argument("--kind", action="append", help="kind of grid, again for more (empty, random 20 %%, maze)")
    parser.add_argument(
        "--planner", action="append", metavar="NAME", help="measure plans of a planner beside dijkstra, again for more"
    )
    parser.add_argument("--largest", type=int, default=8192, metavar="N", help="largest edge in cells (%(default)s)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Measure grids of all sizes, and draw the chart if it is requested."""
    from benchmarks.planners import growth, scaling, tables  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    check_plot(arguments)
    kinds = arguments.kind or scaling.KINDS_SHOWN
    sizes = scaling.sizes_up_to(arguments.largest)
    if arguments.planner:
        told = growth.measure(kinds, sizes, arguments.planner, progress)
        return Measured(told, tables.growth_rows(told))
    told = scaling.measure(kinds, sizes, threads_of(arguments), progress)
    if arguments.plot is not None:
        draw(arguments.plot, scaling.chart(told))
    return Measured(told, tables.scaling_rows(told))
