"""Command ``ppaas token``: tokens for some robots only, and the tokens that ``ppaas login`` creates."""

import argparse
import re
import sys

from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.resource import Resource
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.cli.verbs.robot_shares import add_topic_options, topics_of
from robots.client.cloud_url import path_of

NAME = "token"
HELP = "create tokens for some robots, list your tokens, and delete them to log out"

TOKENS = Resource("tokens", ("id", "name", "created", "expires", "current", "scope"), "no tokens")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    listing = verbs.add_parser("list", help="list your tokens")
    delete = verbs.add_parser("delete", help="delete a token; its holder must log in again")
    configure_create(verbs.add_parser("create", help="create a token for some robots only"))
    add_limit_argument(listing)
    delete.add_argument("id", help="id of the token; 'current' for the one in use")
    for verb in (listing, delete):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


# -- a token for some robots only, such as for a robot or a display ----------------------------------------------------

ROLES = ("look", "drive", "administer", "robot")
UNITS = {"m": 60.0, "h": 3600.0, "d": 86400.0}


def configure_create(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--robot", action="append", required=True, dest="robots", metavar="GLOB",
        help="robots that it is for, as 'tb*'; OWNER:GLOB for robots that are shared with you; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--role", choices=ROLES, required=True, help="what it may do; 'robot': connect as the robot itself"
    )
    parser.add_argument(
        "--topic", action="append", metavar="GLOB", help="the same for --publish and --subscribe, if the role publishes"
    )
    add_topic_options(parser)
    parser.add_argument(
        "--expires", type=_lifetime, metavar="TIME", help="time after which it expires: 30m, 12h, 90d (30d)"
    )
    parser.add_argument("--name", default="", help="what it is for, shown in lists")
    add_session_arguments(parser)


async def create(arguments: argparse.Namespace) -> None:
    """Create a token, and print its text alone."""
    for topic in arguments.topic or ():
        arguments.subscribe = [*(arguments.subscribe or ()), topic]
        if arguments.role != "look":
            arguments.publish = [*(arguments.publish or ()), topic]
    wanted = {"robots": arguments.robots, "role": arguments.role, "name": arguments.name, **topics_of(arguments)}
    if arguments.expires is not None:
        wanted["expires_in"] = arguments.expires
    token = await logged_in(arguments).post(path_of("scoped-tokens"), wanted)
    if arguments.json:
        show(token, (), as_json=True)
    else:
        sys.stdout.write(token["token"] + "\n")


def _lifetime(text: str) -> float:
    found = re.fullmatch(r"(\d{1,6})([mhd])", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"give a time as 30m, 12h or 90d, not {text!r}")
    return int(found[1]) * UNITS[found[2]]


_VERBS = {"create": create, "list": TOKENS.list, "delete": TOKENS.delete}
