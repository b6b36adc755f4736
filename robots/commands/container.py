"""``ppaas container``: what runs on the machines."""

import argparse

from robots.commands import awaited
from robots.commands.resource import Resource
from robots.commands.session import add_limit_argument, add_session_arguments

NAME = "container"
HELP = "list, show and delete containers"

CONTAINERS = Resource(
    "containers",
    ("id", "kind", "user", "robot", "map", "machine", "cores", "state", "pid", "cpu", "pss", "age", "clients"),
    "no containers: a robot has one while it is connected",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    listing = verbs.add_parser("list", help="list your containers; all of them, if you are an admin")
    one = verbs.add_parser("show", help="show one container")
    delete = verbs.add_parser("delete", help="end a container; another takes its place, and the robot drives on")
    add_limit_argument(listing)
    for verb in (one, delete):
        verb.add_argument("id")
    for verb in (listing, one, delete):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Carry out the verb."""
    awaited.run(_VERBS[arguments.verb](arguments))
    return 0


_VERBS = {"list": CONTAINERS.list, "show": CONTAINERS.show, "delete": CONTAINERS.delete}
