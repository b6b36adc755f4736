"""``ppaas bench boards``: rate, memory and pauses of the clients for MicroPython and Arduino."""

import argparse
from typing import TYPE_CHECKING

from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "rate, memory and pauses of the clients for MicroPython and Arduino, beside JSON without them"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--quick", action="store_true", help="few samples: a check that it runs, not for comparison")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return all figures."""
    from benchmarks.boards import arduino, micropython  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from benchmarks.harness.figures import measured  # noqa: PLC0415

    task = progress.add_task("boards", total=2)
    figures = event_loop.run(micropython.measure(quick=arguments.quick))
    progress.advance(task)
    figures += arduino.measure(quick=arguments.quick)
    progress.advance(task)
    return measured(figures)
