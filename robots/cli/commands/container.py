"""Command ``ppaas container``: containers of the cloud."""

import argparse
import math

from ppaas.errors import InvalidInput
from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.resource import Resource
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

NAME = "container"
HELP = "list, show, resize and delete containers"

CONTAINERS = Resource(
    "containers",
    ("id", "kind", "user", "robot", "map", "machine", "cores", "state", "pid", "cpu", "pss", "age", "clients"),
    "no containers; a robot has one while it is connected",
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    listing = verbs.add_parser("list", help="list your containers, or all of them (admin)")
    one = verbs.add_parser("show", help="show one container")
    delete = verbs.add_parser("delete", help="end a container; a new one replaces it while the robot keeps driving")
    resize = verbs.add_parser("resize", help="change the cores of a running container")
    add_limit_argument(listing)
    for verb in (one, resize, delete):
        verb.add_argument("id")
    resize.add_argument("cores", type=float, help="new size [CPU cores]")
    for verb in (listing, one, resize, delete):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


async def _resize(arguments: argparse.Namespace) -> None:
    if not math.isfinite(arguments.cores):
        raise InvalidInput(f"cores must be a finite number, not {arguments.cores}")
    path = path_of("containers", arguments.id)
    resized = await logged_in(arguments).patch(path, {"cores": arguments.cores})
    show(resized, CONTAINERS.columns, as_json=arguments.json)


_VERBS = {"list": CONTAINERS.list, "show": CONTAINERS.show, "resize": _resize, "delete": CONTAINERS.delete}
