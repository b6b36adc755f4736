"""``ppaas bench report``: writes the results of a suite as Markdown."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "the results of a suite, as Markdown"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--write", type=Path, metavar="PAGE.md", help="write the report into a page, between its marks")
    parser.add_argument("file", type=Path, metavar="FILE.json")


def measure(arguments: argparse.Namespace, _: "Progress") -> Measured:
    """Return the text, or write it into the page."""
    from benchmarks.planners import report  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    measured = report.read(arguments.file)
    if arguments.write is None:
        return Measured(measured, text=report.render(measured))
    report.write(arguments.write, measured)
    return Measured(measured)
