"""Command ``ppaas stop``: robots stand until somebody releases them."""

import argparse
from typing import Any

from robots.cli import event_loop
from robots.cli.output import print_line, printable, show
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

NAME = "stop"
HELP = "stop a robot, the robots on a map, or all, until they are released; without a name: list what is stopped"

COLUMNS = ("user", "scope", "name", "by", "since", "reason")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "A stopped robot gets nothing but zero as cmd_vel, from any sender; its goals wait. The stop stays when the "
        "robot, its container or the cloud restarts. 'ppaas release' ends it. 'ppaas robot stop' only cancels goals."
    )
    add_targets(parser)


def add_targets(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that name the robots, and the reason."""
    which = parser.add_mutually_exclusive_group()
    which.add_argument("robot", nargs="?", metavar="ROBOT", help="one robot; OWNER:ID for one of another user")
    which.add_argument("--map", metavar="MAP", help="your robots on this map, also those that connect later")
    which.add_argument(
        "--all", action="store_true", help="all your robots, also those that connect later, and those you may drive"
    )
    parser.add_argument("--reason", default="", metavar="TEXT", help="why, for those who read it later")
    add_session_arguments(parser)


def path_to(arguments: argparse.Namespace, verb: str) -> str | None:
    """Return the path of the resource that a verb is posted to; None if no robots are named."""
    if arguments.all:
        return path_of(verb)
    if arguments.map is not None:
        return path_of("maps", arguments.map, verb)
    return None if arguments.robot is None else path_of("robots", arguments.robot, verb)


def run(arguments: argparse.Namespace) -> int:
    """Stop the robots, or list the stops."""
    event_loop.run(_run(arguments))
    return 0


async def _run(arguments: argparse.Namespace) -> None:
    client, path = logged_in(arguments), path_to(arguments, "stop")
    if path is None:
        show(await client.items(path_of("stops")), COLUMNS, as_json=arguments.json, if_none="nothing is stopped")
        return
    answer = await client.post(path, {"reason": arguments.reason})
    show_answer(answer, "stops", as_json=arguments.json)
    if arguments.json:
        return
    if answer["standing"]:
        print_line(f"standing: {', '.join(map(printable, answer['standing']))}")
    if answer["unconfirmed"]:
        print_line(f"not confirmed: {', '.join(map(printable, answer['unconfirmed']))}")


def show_answer(answer: dict[str, Any], part: str, *, as_json: bool) -> None:
    """Print an answer: all of it as JSON, or its stops in a table."""
    if as_json:
        show(answer, (), as_json=True)
    else:
        show(answer[part], COLUMNS, as_json=False, if_none="nothing was stopped")
