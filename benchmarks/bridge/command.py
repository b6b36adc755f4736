"""``ppaas bench bridge``: latency, CPU time and memory of the bridges of robots with ROS."""

import argparse
from typing import TYPE_CHECKING

from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "latency, CPU time and memory of ppaas bridge ros2 and ros1, beside messages that pass without them"

TRANSPORTS = ("zenoh", "dds", "ros1")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--quick", action="store_true", help="few samples: a check that it runs, not for comparison")
    parser.add_argument(
        "--transport", choices=TRANSPORTS, action="append", help="transport to measure, again for more (all)"
    )


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return all figures."""
    from benchmarks.bridge import measurement  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.harness.figures import measured  # noqa: PLC0415

    transports = arguments.transport or TRANSPORTS
    return measured(event_loop.run(measurement.measure(progress, transports, quick=arguments.quick)))
