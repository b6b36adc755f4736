"""``ppaas bench reuse``: what it saves to look for a path among those that are kept."""

import argparse
from typing import TYPE_CHECKING

from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "speed-up of stored plans over computed ones"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--quick", action="store_true", help="few samples: a check that it runs, not for comparison")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return all figures."""
    import uvloop  # noqa: PLC0415 - what is measured is the cloud, not our own loop

    from benchmarks.harness.figures import measured  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.service import plan_reuse  # noqa: PLC0415

    return measured(event_loop.run(plan_reuse.measure(progress, arguments.quick), uvloop.new_event_loop))
