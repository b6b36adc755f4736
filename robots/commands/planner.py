"""``ppaas planner``: the planners there are, what they are for and what can be set."""

import argparse
import asyncio
from typing import Any

from robots.commands.resource import Resource
from robots.commands.session import add_limit_argument, add_session_arguments
from robots.commands.table import show

NAME = "planner"
HELP = "list and show the planners there are"

PLANNERS = Resource(
    "planners",
    ("name", "aliases", "optimal", "weighted", "any_angle", "kinematic", "indexed", "incremental", "purpose"),
    "no planner is installed",
    list_columns=("name", "optimal", "purpose"),
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    listing = verbs.add_parser("list", help="list the planners")
    one = verbs.add_parser("show", help="show one planner")
    add_limit_argument(listing)
    one.add_argument("id", metavar="NAME", help="its own name")
    for verb in (listing, one):
        verb.add_argument("--here", action="store_true", help="those installed here, instead of the cloud's")
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Carry out the verb."""
    if arguments.here:
        _show_here(arguments)
    else:
        asyncio.run(_VERBS[arguments.verb](arguments))
    return 0


def _show_here(arguments: argparse.Namespace) -> None:
    from ppaas.planners.catalogue import catalogue, entry, told  # noqa: PLC0415 - ``ppaas --help`` loads this module

    found: Any = told(entry(arguments.id)) if arguments.verb == "show" else catalogue()[: arguments.limit]
    show(found, PLANNERS.columns if arguments.verb == "show" else PLANNERS.list_columns, as_json=arguments.json)


_VERBS = {"list": PLANNERS.list, "show": PLANNERS.show}
"""What is asked of the cloud."""
