"""``ppaas bench NAME``: measures planners, or a cloud on this machine, by the benches that are installed."""

import argparse
from importlib.metadata import entry_points

from ppaas.errors import Unavailable
from robots.cli import event_loop
from robots.cli.benches import GROUP, Bench, Measured
from robots.cli.command_parser import CommandParser
from robots.cli.output import print_line, show
from robots.cli.plugins import add_missing, loaded

NAME = "bench"
HELP = "measure planners, or a cloud on this machine, beside yardsticks"

WHERE = "the wheel of ppaas has no benches; in a checkout of its repository: pip install -e . -e benchmarks"
"""Told where none is installed."""


def configure(parser: CommandParser) -> None:
    """Add the bench that is asked for with its arguments, or all of them; none where another command is asked for."""
    if parser.words is None:
        return
    entries = entry_points(group=GROUP)
    if not entries:
        if parser.words[:1] not in (["-h"], ["--help"]):
            raise Unavailable(WHERE)
        parser.description = f"{HELP}: {WHERE}"
        return
    kinds = parser.add_subparsers(title="what", metavar="WHAT", required=True)
    for name, bench in loaded(entries, parser.words):
        if isinstance(bench, ModuleNotFoundError):
            add_missing(kinds, name, bench)
            continue
        kind = kinds.add_parser(name, help=bench.HELP, description=bench.HELP)
        bench.configure(kind)
        kind.add_argument("--json", action="store_true", help="print the result as one JSON object")
        kind.set_defaults(bench=bench)


def run(arguments: argparse.Namespace) -> int:
    """Measure and print; the exit status is 0 whatever the figures are, but 1 where a cloud did not stand the chaos."""
    with event_loop.terminable():
        measured = _measure(arguments)
    # Not before the progress is gone: while it is shown, whatever is printed goes where it goes.
    if arguments.json:
        show(measured.told, (), as_json=True)
    elif measured.text:
        print_line(measured.text)
    elif measured.rows:
        show(measured.rows, tuple(measured.rows[0]), as_json=False)
    return measured.status


def _measure(arguments: argparse.Namespace) -> Measured:
    from rich.console import Console  # noqa: PLC0415 - a robot's install has neither rich nor the simulation
    from rich.progress import Progress  # noqa: PLC0415

    bench: Bench = arguments.bench
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        return bench.measure(arguments, progress)
