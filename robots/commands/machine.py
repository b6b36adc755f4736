"""``ppaas machine``: the machines and what runs on them."""

import argparse
import asyncio

from robots.commands.session import add_session_arguments, logged_in
from robots.commands.table import show

NAME = "machine"
HELP = "list machines and the containers on them"

MACHINES = ("id", "cores", "capacity", "containers", "load", "memory_used", "memory")
CONTAINERS = ("id", "kind", "user", "robot", "map", "machine", "cores", "state", "pid", "pss", "ready_seconds")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    machines = verbs.add_parser("list", help="list the machines (admin)")
    containers = verbs.add_parser("containers", help="list your containers; all of them, if you are an admin")
    for verb in (machines, containers):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Carry out the verb."""
    path, columns, none = _VERBS[arguments.verb]
    show(asyncio.run(logged_in(arguments).get(path)), columns, as_json=arguments.json, if_none=none)
    return 0


_VERBS = {
    "list": ("/v1/machines", MACHINES, "no machine is there now: see the log of the cloud"),
    "containers": ("/v1/containers", CONTAINERS, "no containers: a robot has one while it is connected"),
}
