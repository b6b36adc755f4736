"""Verb ``ppaas robot nodes``: shows where the nodes of a robot run and why, and moves one."""

import argparse
from typing import Any

from robots.cli.output import show
from robots.cli.session import add_session_arguments, logged_in
from robots.client.rest_paths import path_of

COLUMNS = ("node", "home", "wanted", "score", "why")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    parser.add_argument("id", help="id of a connected robot")
    parser.add_argument("--run", dest="node", metavar="NODE", help="move this node to the home where it performs best")
    parser.add_argument("--home", choices=("cloud", "robot"), help="with --run: the home to move it to")
    add_session_arguments(parser)


async def run(arguments: argparse.Namespace) -> None:
    """Execute the verb."""
    client = logged_in(arguments)
    nodes = path_of("robots", arguments.id, "nodes")
    if arguments.node is None:
        found = await client.items(nodes)
    else:
        path = path_of("robots", arguments.id, "nodes", arguments.node)
        found = [await client.post(path, {"home": arguments.home})]
    show(found if arguments.json else list(map(_row, found)), COLUMNS, as_json=arguments.json)


def _row(node: dict[str, Any]) -> dict[str, Any]:
    return node | {"score": round(node["score"], 2), "why": "; ".join(node["reasons"])}
