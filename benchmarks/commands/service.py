"""``ppaas bench service``: waiting times of a cloud's user, part by part."""

import argparse
from typing import TYPE_CHECKING

from robots.cli import event_loop
from robots.cli.benches import Measured
from robots.cli.session import add_cloud_arguments, token_of

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "waiting times of a user, from the start of a cloud to driving robots"

PARTS = ("startup", "first", "plans", "load", "maps", "containers", "fleet", "dashboard", "push")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_cloud_arguments(parser)
    parser.set_defaults(url=None)
    parser.add_argument(
        "--only",
        choices=PARTS,
        metavar="NAME",
        action="append",
        help=f"part to measure, again for more: {', '.join(PARTS)} (all)",
    )
    parser.add_argument("--quick", action="store_true", help="few samples: a check that it runs, not for comparison")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the figures of the chosen parts."""
    import uvloop  # noqa: PLC0415 - what is measured is the cloud, not our own loop

    from benchmarks.harness.figures import measured  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.service import suite  # noqa: PLC0415

    token = token_of(arguments) if arguments.url else None
    options = suite.ServiceOptions(tuple(arguments.only or ()), arguments.quick, arguments.url, token)
    return measured(event_loop.run(suite.measure(options, progress), uvloop.new_event_loop))
