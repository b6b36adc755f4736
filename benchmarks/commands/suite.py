"""``ppaas bench suite``: measures all figures of planners in ``docs/performance.md``, and stores them in a file."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "all figures of a planner report, stored in a JSON file"

PARTS = ("fields", "comparisons", "scaling", "lengths", "scenarios", "indexes")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--data", type=Path, metavar="FOLDER", help="folder with real maps in ros/ and movingai/")
    parser.add_argument(
        "--only",
        choices=PARTS,
        metavar="PART",
        action="append",
        help=f"part to measure, again for more: {', '.join(PARTS)} (all)",
    )
    parser.add_argument("--quick", action="store_true", help="small grids: a check that it runs, not for comparison")
    parser.add_argument("file", type=Path, metavar="FILE.json")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Measure the parts one after the other, and keep each in the file."""
    from benchmarks.planners import report, suite  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    measured = report.read(arguments.file)
    options = suite.PlannerSuiteOptions(arguments.data, tuple(arguments.only or ()), arguments.quick)
    for part, told in suite.measure(options, progress):
        measured[part] = told
        report.keep(arguments.file, measured)  # at once, as later parts may take long or fail
    return Measured(measured)
