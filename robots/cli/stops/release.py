"""Command ``ppaas release``: releases robots that are stopped."""

import argparse

from ppaas.errors import InvalidInput
from robots.cli import event_loop
from robots.cli.output import print_line, show
from robots.cli.session import logged_in
from robots.cli.stops.stop import COLUMNS, add_targets, path_to, show_answer

NAME = "release"
HELP = "release a robot, the robots on a map, or all, after 'ppaas stop'"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Each stop is released by its name: a robot that was stopped alone still stands after --all. Robots drive on "
        "to their goals at once. Who stopped a robot may release it, and who may administer it."
    )
    add_targets(parser)


def run(arguments: argparse.Namespace) -> int:
    """Release the robots."""
    path = path_to(arguments, "release")
    if path is None:
        raise InvalidInput("name what to release: ROBOT, --map MAP or --all; 'ppaas stop' lists what is stopped")
    event_loop.run(_release(arguments, path))
    return 0


async def _release(arguments: argparse.Namespace, path: str) -> None:
    answer = await logged_in(arguments).post(path, {"reason": arguments.reason})
    show_answer(answer, "released", as_json=arguments.json)
    if answer["left"] and not arguments.json:
        print_line("still stopped by:")
        show(answer["left"], COLUMNS, as_json=False)
