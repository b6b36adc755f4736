"""``ppaas bench suite|report``: what ``docs/performance.md`` tells of planners, measured and written."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robots.cli.output import print_line

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = {
    "suite": "all that a report tells of planners, kept in a file of JSON",
    "report": "what a suite measured, as Markdown",
}

PARTS = ("fields", "comparisons", "scaling", "lengths", "scenarios", "indexes")


def configure(kinds: Any) -> None:
    """Add the verbs and their arguments to the subparsers of ``ppaas bench``."""
    verbs = {name: kinds.add_parser(name, help=text, description=text) for name, text in HELP.items()}
    suite, report = verbs["suite"], verbs["report"]
    suite.add_argument("--data", type=Path, metavar="FOLDER", help="with real maps: ros/ and movingai/")
    suite.add_argument("--only", choices=PARTS, metavar="PART", action="append", help=f"of {', '.join(PARTS)}")
    suite.add_argument("--quick", action="store_true", help="small grids: to see that it runs, not to compare")
    report.add_argument("--write", type=Path, metavar="PAGE.md", help="into a page, between its marks")
    for name, verb in verbs.items():
        verb.add_argument("file", type=Path, metavar="FILE.json")
        verb.set_defaults(what=name)


def measure(arguments: argparse.Namespace, progress: "Progress") -> Callable[[], None]:
    """Measure, or write; return what prints the rest."""
    return _suite(arguments, progress) if arguments.what == "suite" else _report(arguments)


def _suite(arguments: argparse.Namespace, progress: "Progress") -> Callable[[], None]:
    from benchmarks.planners import report, suite  # noqa: PLC0415 - ``ppaas --help`` loads this

    measured = report.read(arguments.file)
    options = suite.Options(arguments.data, tuple(arguments.only or ()), arguments.quick)
    for part, told in suite.measure(options, progress):
        measured[part] = told
        report.keep(arguments.file, measured)  # at once: what comes later may take long, or fail
    return lambda: None


def _report(arguments: argparse.Namespace) -> Callable[[], None]:
    from benchmarks.planners import report  # noqa: PLC0415

    measured = report.read(arguments.file)
    if arguments.write is None:
        return lambda: print_line(report.render(measured))
    report.write(arguments.write, measured)
    return lambda: None
