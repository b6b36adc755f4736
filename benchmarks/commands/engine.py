"""``ppaas bench engine``: start, crash and number of containers, lost machines, the master, and messages."""

import argparse
from typing import TYPE_CHECKING

from ppaas.bounded import whole
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "the engine: start and recovery of containers, capacity of a machine, placements, messages, coordinators"

PARTS = ("ready", "crowd", "crash", "lost", "messages", "people", "standby", "master")
RUNTIMES = ("process", "docker", "ray")
MOST_CONTAINERS, MOST_PLACEMENTS, MOST_MACHINES = 2_000, 1_000_000, 10_000


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--only",
        choices=PARTS,
        metavar="NAME",
        action="append",
        help=f"part to measure, again for more: {', '.join(PARTS)} (all)",
    )
    parser.add_argument(
        "--runtime", choices=RUNTIMES, default="process", help="runtime of the containers (%(default)s)"
    )
    parser.add_argument("--containers", type=whole(most=MOST_CONTAINERS), default=100, metavar="N",
                        help="containers at once on one machine (%(default)s)")  # fmt: skip
    parser.add_argument("--placements", type=whole(most=MOST_PLACEMENTS), default=10_000, metavar="N",
                        help="placements by the master (%(default)s)")  # fmt: skip
    parser.add_argument("--machines", type=whole(most=MOST_MACHINES), default=1_000, metavar="N",
                        help="machines of these placements (%(default)s)")  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="few samples: a check that it runs, not for comparison")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the figures of the chosen parts."""
    import uvloop  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    from benchmarks.engine import suite  # noqa: PLC0415
    from benchmarks.engine.options import EngineOptions  # noqa: PLC0415
    from benchmarks.harness.figures import measured  # noqa: PLC0415

    options = EngineOptions(
        tuple(arguments.only or ()), arguments.quick, arguments.runtime, arguments.containers,
        arguments.placements, arguments.machines,
    )  # fmt: skip
    return measured(event_loop.run(suite.measure(options, progress), uvloop.new_event_loop))
