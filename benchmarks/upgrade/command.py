"""``ppaas bench upgrade``: upgrades a cloud, one process after another, while robots drive."""

import argparse
import sys
from typing import TYPE_CHECKING

from ppaas.bounded import above_zero, whole
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "upgrade a cloud from another release, one process after another, while robots drive: reports what they notice"

MOST_ROBOTS = 32


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--from", dest="before", default=sys.executable, metavar="PYTHON",
        help="Python of an environment in which the release before is installed, as 'make upgrade' makes it "
        "(this one: an upgrade to the same release)",
    )  # fmt: skip
    parser.add_argument(
        "--to", default=sys.executable, metavar="PYTHON", help="the same for the release after (this one)"
    )
    parser.add_argument(
        "--robots", type=whole(most=MOST_ROBOTS), default=6, metavar="N", help="number of robots (%(default)s)"
    )
    parser.add_argument(
        "--settle", type=above_zero(600.0), default=10.0, metavar="SECONDS", help="time between steps (%(default)s)"
    )
    parser.add_argument(
        "--kill",
        action="store_true",
        help="kill each process (SIGKILL) instead of ending it, and the new one while it starts",
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of maps, courses and kills (%(default)s)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Run the bench; the exit status is 1 if a goal was lost or a robot stood."""
    from benchmarks.upgrade.run import UpgradeOptions, run  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    options = UpgradeOptions(
        before=arguments.before,
        after=arguments.to,
        robots=arguments.robots,
        kill=arguments.kill,
        settle=arguments.settle,
        seed=arguments.seed,
    )
    return Measured.of(event_loop.run(run(options, progress)))
