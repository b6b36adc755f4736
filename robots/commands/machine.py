"""``ppaas machine``: the machines of the cloud."""

import argparse

from robots.commands import awaited
from robots.commands.resource import Resource
from robots.commands.session import add_limit_argument, add_session_arguments

NAME = "machine"
HELP = "list and show the machines (admin)"

MACHINES = Resource(
    "machines",
    ("id", "cores", "capacity", "containers", "load", "memory_used", "memory"),
    "no machine is there now: see the log of the cloud",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    listing = verbs.add_parser("list", help="list the machines")
    one = verbs.add_parser("show", help="show one machine")
    add_limit_argument(listing)
    one.add_argument("id")
    for verb in (listing, one):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Carry out the verb."""
    awaited.run(_VERBS[arguments.verb](arguments))
    return 0


_VERBS = {"list": MACHINES.list, "show": MACHINES.show}
