"""``ppaas bench compare``: compares our planners with packages from PyPI on the same grid."""

import argparse
from typing import TYPE_CHECKING

from benchmarks.planners.grid_arguments import (
    add_goal_argument,
    add_grid_arguments,
    add_threads_argument,
    goal_of,
    grid_of,
    tell_left_out,
    threads_of,
)
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "our planners and installed packages from PyPI on the same grid"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_grid_arguments(parser)
    add_goal_argument(parser)
    add_threads_argument(parser)
    parser.add_argument(
        "--only", action="append", metavar="PACKAGE", help="package to compare with (all that are installed)"
    )


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Measure our planners and the peers."""
    from benchmarks.planners import compare, tables  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    only = tuple(arguments.only or ())
    told = compare.measure(grid_of(arguments), goal_of(arguments), threads_of(arguments), only, progress)
    tell_left_out(told, progress)
    return Measured(told, tables.compare_rows(told))
