"""``ppaas bench chaos``: kills and stops random processes of a cloud while robots drive."""

import argparse
from typing import TYPE_CHECKING

from ppaas.bounded import above_zero, whole
from ppaas.errors import InvalidInput
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "kill and stop random processes of a cloud while robots drive: reports losses and leftovers"

MOST_ROBOTS, MOST_MACHINES, MOST_THROTTLED = 32, 8, 16
LONGEST = 24 * 60.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--minutes", type=above_zero(LONGEST), default=10.0, metavar="N",
                        help="duration of the faults (%(default)s)")  # fmt: skip
    parser.add_argument(
        "--robots", type=whole(0, MOST_ROBOTS), default=10, metavar="N", help="number of robots (%(default)s)"
    )
    parser.add_argument(
        "--operators", type=whole(0, MOST_ROBOTS), default=3, metavar="N",
        help="number of robots to which an operator with a connection of its own sends the goals (%(default)s)",
    )  # fmt: skip
    parser.add_argument("--machines", type=whole(most=MOST_MACHINES), default=3, metavar="N",
                        help="number of machines, the cloud's local one included (%(default)s)")  # fmt: skip
    parser.add_argument("--every", type=above_zero(600.0), default=5.0, metavar="SECONDS",
                        help="mean time between faults (%(default)s)")  # fmt: skip
    parser.add_argument(
        "--standby",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="let a second cloud process stand by, which takes over when the first one is killed or stopped, and the "
        "other way around (%(default)s)",
    )
    parser.add_argument(
        "--fleet",
        type=whole(0, MOST_ROBOTS),
        default=0,
        metavar="N",
        help="number of further robots, which take part in the traffic of a warehouse (%(default)s)",
    )
    parser.add_argument(
        "--throttled",
        type=whole(0, MOST_THROTTLED),
        default=0,
        metavar="N",
        help="number of further clients of each robot, which subscribe with throttle rates (%(default)s)",
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the faults (%(default)s)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Run the bench; the exit status is 1 if it found errors."""
    from benchmarks.chaos.run import ChaosOptions, run  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    if not arguments.robots + arguments.fleet:
        raise InvalidInput("there must be at least one robot: give --robots or --fleet")
    options = ChaosOptions(
        seconds=60.0 * arguments.minutes,
        robots=arguments.robots,
        operators=arguments.operators,
        machines=arguments.machines,
        standby=arguments.standby,
        every=arguments.every,
        seed=arguments.seed,
        fleet=arguments.fleet,
        throttled=arguments.throttled,
    )
    return Measured.of(event_loop.run(run(options, progress)))
