"""``ppaas bench vda5050``: CPU time and memory of bridges with many robots as AGVs, and many AGVs as robots."""

import argparse
from typing import TYPE_CHECKING

from ppaas.bounded import whole
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "CPU time and memory of ppaas bridge vda5050 and ppaas bridge agv with many robots, over mosquitto"

ROBOTS, QUICK_ROBOTS = 200, 5
"""Numbers of robots."""

SECONDS, QUICK_SECONDS = 20.0, 3.0
"""Times for which the bridge is measured [s]."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--quick", action="store_true", help="few robots: a check that it runs, not for comparison")
    parser.add_argument("--robots", type=whole(1, 500), help=f"number of robots ({ROBOTS})")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return all figures."""
    from benchmarks.harness.figures import measured  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.vda5050 import agvs, measurement  # noqa: PLC0415

    robots = arguments.robots or (QUICK_ROBOTS if arguments.quick else ROBOTS)
    seconds = QUICK_SECONDS if arguments.quick else SECONDS
    presented = event_loop.run(measurement.measure(progress, robots, seconds))
    taken = event_loop.run(agvs.measure(progress, robots, seconds))
    return measured([*presented, *taken])
