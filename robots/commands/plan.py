"""``ppaas plan``: a path without a robot."""

import argparse
import asyncio

from ppaas.errors import InvalidInput
from robots.commands.session import add_session_arguments, logged_in
from robots.commands.table import show

NAME = "plan"
HELP = "have the cloud plan a path on a map"

COLUMNS = ("plan_id", "planner", "length", "cost", "expanded", "seconds", "container", "pid")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("map", help="id of the map")
    for end in ("start", "goal"):
        parser.add_argument(f"--{end}", nargs="+", type=float, required=True, metavar="N", help="x y [yaw], m and rad")
    parser.add_argument("--planner", default="dijkstra", help="(%(default)s)")
    parser.add_argument("--tolerance", type=float, default=0.0, help="metres around a goal that is blocked (0)")
    add_session_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print what was planned; its poses too, with ``--json``."""
    for end in ("start", "goal"):
        numbers = len(getattr(arguments, end))
        if numbers not in (2, 3):
            raise InvalidInput(f"--{end} takes x y [yaw] in metres and radians, not {numbers} numbers")
    options = {"planner": arguments.planner, "tolerance": arguments.tolerance}
    answer = asyncio.run(logged_in(arguments).plan(arguments.map, arguments.start, arguments.goal, **options))
    show(answer, COLUMNS, as_json=arguments.json)
    return 0
