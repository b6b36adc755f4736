"""``ppaas bench wire``: latency, CPU time and memory of endpoints."""

import argparse
from typing import TYPE_CHECKING

from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "latency, CPU time and memory of endpoints, beside bare programs that carry the same frames"

PARTS = ("latency", "cpu", "memory", "half-open", "endpoints")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
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
    import uvloop  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    from benchmarks.harness.figures import measured  # noqa: PLC0415
    from benchmarks.harness.parts import PartSelection  # noqa: PLC0415
    from benchmarks.wire import suite  # noqa: PLC0415

    options = PartSelection(tuple(arguments.only or ()), arguments.quick)
    return measured(event_loop.run(suite.measure(options, progress), uvloop.new_event_loop))
