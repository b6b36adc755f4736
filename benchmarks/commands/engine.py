"""``ppaas bench engine``: containers that start, crash and are many; machines that are lost; the master; messages."""

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from ppaas.bounded_numbers import whole
from robots.cli.output import print_line

if TYPE_CHECKING:
    from rich.progress import Progress

NAME = "engine"
HELP = "the engine: how soon containers are ready and served again, how many, placements, messages"

PARTS = ("ready", "crowd", "crash", "lost", "messages", "master")
RUNTIMES = ("process", "docker", "ray")
MOST_CONTAINERS, MOST_PLACEMENTS, MOST_MACHINES = 2_000, 1_000_000, 10_000


def configure(kinds: Any) -> None:
    """Add the bench and its arguments to the subparsers of ``ppaas bench``."""
    parser = kinds.add_parser(NAME, help=HELP, description=HELP)
    parser.add_argument("--only", choices=PARTS, metavar="NAME", action="append", help=f"of {', '.join(PARTS)}")
    parser.add_argument("--runtime", choices=RUNTIMES, default="process", help="starts containers (%(default)s)")
    parser.add_argument("--containers", type=whole(most=MOST_CONTAINERS), default=100, metavar="N",
                        help="at a time on one machine (%(default)s)")  # fmt: skip
    parser.add_argument("--placements", type=whole(most=MOST_PLACEMENTS), default=10_000, metavar="N",
                        help="by the master (%(default)s)")  # fmt: skip
    parser.add_argument("--machines", type=whole(most=MOST_MACHINES), default=1_000, metavar="N",
                        help="that these are on (%(default)s)")  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="few samples: to see that it runs, not to compare")
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")
    parser.set_defaults(what=NAME, measure=measure)


def measure(arguments: argparse.Namespace, progress: "Progress") -> Callable[[], None]:
    """Measure; return what prints the figures."""
    import uvloop  # noqa: PLC0415 - ``ppaas --help`` loads this
    from rich.console import Console  # noqa: PLC0415

    from benchmarks.engine.options import Options  # noqa: PLC0415
    from benchmarks.engine.suite import measure as measure_all  # noqa: PLC0415
    from benchmarks.harness.figures import show, to_json  # noqa: PLC0415

    options = Options(
        tuple(arguments.only or ()), arguments.quick, arguments.runtime, arguments.containers,
        arguments.placements, arguments.machines,
    )  # fmt: skip
    figures = uvloop.run(measure_all(options, progress))
    if arguments.json:
        return lambda: print_line(to_json(figures))
    return lambda: show(figures, Console())
