"""``ppaas bench building``: robots in buildings."""

import argparse
from typing import TYPE_CHECKING

from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "robots in buildings: rides in lifts, after which floor and pose must be known"

RIDES, QUICK = 1000, 20
"""Number of rides, and of those with ``--quick``."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--rides", type=int, default=RIDES, metavar="N", help=f"number of rides ({RIDES})")
    parser.add_argument("--seed", type=int, default=1, help="seed of buildings and rides (1)")
    parser.add_argument("--quick", action="store_true", help="little time: a check that it runs, not for comparison")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the figures."""
    from benchmarks.building import rides  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.harness.figures import measured  # noqa: PLC0415

    count = QUICK if arguments.quick else arguments.rides
    track = progress.track(rides.measure(count, arguments.seed), total=count, description="rides")
    scores = list(track)[-1]
    return measured(list(rides.figures(scores)))
