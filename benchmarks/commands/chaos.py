"""``ppaas bench chaos``: processes of a cloud are killed and stopped at random while robots drive in it."""

import argparse
import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ppaas.bounded_numbers import above_zero, whole
from robots.cli.output import print_line, table

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = {"chaos": "kill and stop processes of a cloud at random under driving robots: what is lost, or left behind"}

MOST_ROBOTS, MOST_MACHINES = 32, 8
LONGEST = 24 * 60.0


def configure(kinds: Any) -> None:
    """Add the verb and its arguments to the subparsers of ``ppaas bench``."""
    chaos = kinds.add_parser("chaos", help=HELP["chaos"], description=HELP["chaos"])
    chaos.add_argument("--minutes", type=above_zero(LONGEST), default=10.0, metavar="N", help="of faults (%(default)s)")
    chaos.add_argument("--robots", type=whole(most=MOST_ROBOTS), default=10, metavar="N", help="(%(default)s)")
    chaos.add_argument(
        "--machines",
        type=whole(most=MOST_MACHINES),
        default=3,
        metavar="N",
        help="the cloud's own included (%(default)s)",
    )
    chaos.add_argument(
        "--every",
        type=above_zero(600.0),
        default=5.0,
        metavar="SECONDS",
        help="between faults, on average (%(default)s)",
    )
    chaos.add_argument("--seed", type=int, default=1, help="the same seed does the same faults (%(default)s)")
    chaos.add_argument("--json", action="store_true", help="print the result as one JSON object")
    chaos.set_defaults(what="chaos")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Callable[[], int]:
    """Run it; return what prints the report, and then returns 1 where something is wrong."""
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads this

    import msgspec  # noqa: PLC0415

    from benchmarks.chaos.run import Options, run  # noqa: PLC0415

    options = Options(60.0 * arguments.minutes, arguments.robots, arguments.machines, arguments.every, arguments.seed)
    report = asyncio.run(run(options, progress))

    def show() -> int:
        if arguments.json:
            print_line(json.dumps(msgspec.to_builtins(report)))
        else:
            rows = report.rows()
            print_line("\n".join([*(table(rows, tuple(rows[0])) if rows else ()), *report.sentences()]))
        return 0 if report.passed else 1

    return show
