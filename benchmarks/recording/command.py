"""``ppaas bench recording``: CPU time and size of the recording of a driving robot."""

import argparse
from typing import TYPE_CHECKING

from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "CPU time and size of the recording of a driving robot, beside the same drive without it"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--quick", action="store_true", help="short turns: a check that it runs, not for comparison")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return all figures."""
    from benchmarks.harness.figures import measured  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.recording import measurement  # noqa: PLC0415

    return measured(event_loop.run(measurement.measure(progress, quick=arguments.quick)))
