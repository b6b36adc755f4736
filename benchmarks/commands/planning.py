"""``ppaas bench planning``: time to prepare maps, to convert depth images to scans, and to plan paths."""

import argparse
from typing import TYPE_CHECKING

from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "preparation of maps, scans from depth images, and planning, without a cloud"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--quick", action="store_true", help="few samples: a check that it runs, not for comparison")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return all figures."""
    from benchmarks.harness.figures import measured  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.planners import planning, preparation  # noqa: PLC0415

    return measured(planning.measure(progress, arguments.quick) + preparation.measure(progress, arguments.quick))
