"""``ppaas bench planning``: how long maps take to be prepared, depth images to be read, and paths to be planned."""

import argparse
from typing import TYPE_CHECKING

from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "preparing maps, making scans of depth images, and planning paths, without a cloud"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--quick", action="store_true", help="few samples: to see that it runs, not to compare")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return all figures."""
    from benchmarks.harness.figures import measured  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.planners import planning, preparation  # noqa: PLC0415

    return measured(planning.measure(progress, arguments.quick) + preparation.measure(progress, arguments.quick))
