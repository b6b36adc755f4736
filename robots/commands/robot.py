"""``ppaas robot``: tell of robots, list, show and delete them."""

import argparse
import asyncio
from pathlib import Path
from urllib.parse import quote

from robots.commands.session import add_session_arguments, logged_in
from robots.commands.table import show

NAME = "robot"
HELP = "put, list, show and delete robots"

COLUMNS = ("id", "map", "model", "initial_pose", "cores", "base_global_planner", "base_local_planner")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    put = verbs.add_parser("put", help="tell of a robot, or change it, by its JSON file")
    listing = verbs.add_parser("list", help="list your robots")
    one = verbs.add_parser("show", help="show one robot")
    delete = verbs.add_parser("delete", help="delete a robot")
    for verb in (put, one, delete):
        verb.add_argument("id")
    put.add_argument("file", type=Path, help="the robot file")
    for verb in (put, listing, one, delete):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Carry out the verb."""
    asyncio.run(_VERBS[arguments.verb](arguments))
    return 0


async def _put(arguments: argparse.Namespace) -> None:
    from robots.robot_file import load_robot_file  # noqa: PLC0415 - ``ppaas --help`` loads this module

    client = logged_in(arguments)
    await client.put_robot(arguments.id, load_robot_file(arguments.file))
    await _show(arguments)


async def _list(arguments: argparse.Namespace) -> None:
    none = "no robots: ppaas robot put ID FILE.json"
    show(await logged_in(arguments).get("/v1/robots"), COLUMNS, as_json=arguments.json, if_none=none)


async def _show(arguments: argparse.Namespace) -> None:
    show(await logged_in(arguments).get(_path(arguments.id)), COLUMNS, as_json=arguments.json)


async def _delete(arguments: argparse.Namespace) -> None:
    await logged_in(arguments).delete(_path(arguments.id))


def _path(robot_id: str) -> str:
    return f"/v1/robots/{quote(robot_id, safe='')}"


_VERBS = {"put": _put, "list": _list, "show": _show, "delete": _delete}
