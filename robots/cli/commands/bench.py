"""Command ``ppaas bench NAME``: runs one of the installed benches."""

import argparse
from importlib.metadata import entry_points

from ppaas.errors import Unavailable
from robots.cli import event_loop
from robots.cli.benches import GROUP, Bench, Measured
from robots.cli.command_parser import CommandParser
from robots.cli.output import print_line, show
from robots.cli.plugins import installed

NAME = "bench"
HELP = "measure planners, or a cloud on this machine, against baselines"

WHERE = "no benches are installed (the wheel has none); in a checkout of ppaas: pip install -e . -e benchmarks"
"""Error if no bench is installed."""


def configure(parser: CommandParser) -> None:
    """Add the bench that is called with its arguments, or all benches; none if another command is called."""
    if parser.words is None:
        return
    entries = entry_points(group=GROUP)
    if not entries:
        if parser.words[:1] not in (["-h"], ["--help"]):
            raise Unavailable(WHERE)
        parser.description = f"{HELP}: {WHERE}"
        return
    kinds = parser.add_subparsers(title="what", metavar="WHAT", required=True)
    for name, bench in installed(kinds, entries, parser.words):
        kind = kinds.add_parser(name, help=bench.HELP, description=bench.HELP)
        bench.configure(kind)
        kind.add_argument("--json", action="store_true", help="print the result as one JSON object")
        kind.set_defaults(bench=bench)


def run(arguments: argparse.Namespace) -> int:
    """Run the bench and print its result; return its exit status: 0, but 1 if a cloud failed the chaos bench."""
    with event_loop.terminable():
        measured = _measure(arguments)
    # Only after the progress display has closed, since it redirects the output.
    if arguments.json:
        show(measured.result, (), as_json=True)
    elif measured.text:
        print_line(measured.text)
    elif measured.rows:
        show(measured.rows, tuple(measured.rows[0]), as_json=False)
    return measured.status


def _measure(arguments: argparse.Namespace) -> Measured:
    from rich.console import Console  # noqa: PLC0415 - a robot's install lacks rich and the simulator
    from rich.progress import Progress  # noqa: PLC0415

    bench: Bench = arguments.bench
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        return bench.measure(arguments, progress)
