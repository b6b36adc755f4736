"""``ppaas bench alerts``: breaks a cloud, waits until the alerts fire, mends it, and waits until they resolve."""

import argparse
from typing import TYPE_CHECKING

from ppaas.bounded import above_zero
from robots.cli import event_loop
from robots.cli.benches import Measured
from robots.cli.output import table

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "breaks a cloud until the alerts of Prometheus fire, mends it until they resolve, and reports both"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--faster", type=above_zero(1000.0), default=30.0, metavar="FACTOR",
        help="factor by which the times of the rules are shorter; 1 for the rules as they are, which takes more than "
        "an hour (%(default)g)",
    )  # fmt: skip
    parser.add_argument("--only", action="append", metavar="ALERT", help="alert to see, again for more (all)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Run the bench; the exit status is 1 if an alert did not fire or did not resolve."""
    import msgspec  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    from benchmarks.alerts.run import run  # noqa: PLC0415

    seen = event_loop.run(run(arguments.faster, tuple(arguments.only or ()), progress))
    rows = [one.row() for one in seen]
    complete = all(one.resolved is not None for one in seen)
    return Measured(msgspec.to_builtins(seen), text="\n".join(table(rows, tuple(rows[0]))), status=0 if complete else 1)
