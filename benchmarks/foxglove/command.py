"""``ppaas bench foxglove``: CPU time of the endpoint for a viewer of many robots."""

import argparse
from typing import TYPE_CHECKING

from ppaas.bounded import whole
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "CPU time of a viewer of Foxglove that looks at many robots, beside foxglove-sdk's own server"

ROBOTS, QUICK_ROBOTS = 20, 2
"""Numbers of robots."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--quick", action="store_true", help="few robots: a check that it runs, not for comparison")
    parser.add_argument("--robots", type=whole(1, 100), help=f"number of robots ({ROBOTS})")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return all figures."""
    from benchmarks.foxglove import measurement  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.harness.figures import measured  # noqa: PLC0415

    robots = arguments.robots or (QUICK_ROBOTS if arguments.quick else ROBOTS)
    return measured(event_loop.run(measurement.measure(progress, robots, quick=arguments.quick)))
