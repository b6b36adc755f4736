"""``ppaas bench index``: time to prepare a grid for a planner, and correctness of its answers."""

import argparse
from typing import TYPE_CHECKING

from benchmarks.planners.grid_arguments import add_grid_arguments, add_threads_argument, grid_of, threads_of
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "the index of a grid: time to build it by number of threads, and correctness of queries"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_grid_arguments(parser)
    add_threads_argument(parser)
    parser.add_argument("--planner", default="hub_labels", help="planner that prepares a map (%(default)s)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Prepare the grid with each number of threads, and query it."""
    from benchmarks.planners import index, tables  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    told = index.measure(grid_of(arguments), arguments.planner, threads_of(arguments), progress)
    return Measured(told, tables.index_rows(told))
