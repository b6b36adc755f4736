"""``ppaas map``: publish, list, show and delete maps."""

import argparse
import asyncio
from pathlib import Path
from urllib.parse import quote

from robots.commands.session import add_session_arguments, logged_in
from robots.commands.table import show

NAME = "map"
HELP = "publish, list, show and delete maps"

LIST_COLUMNS = ("id", "owner", "version", "readers")
COLUMNS = ("id", "owner", "version", "width", "height", "resolution", "origin", "readers")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    publish = verbs.add_parser("publish", help="publish a map of map_server, or its new version")
    publish.add_argument("yaml", type=Path, help="its YAML file; the image is found by it")
    publish.add_argument("--id", help="of the map (the name of the YAML file)")
    publish.add_argument("--reader", action="append", default=[], help="who else may use it; * is everybody")
    listing = verbs.add_parser("list", help="list the maps that you may use")
    one = verbs.add_parser("show", help="show one map")
    delete = verbs.add_parser("delete", help="delete a map")
    for verb in (one, delete):
        verb.add_argument("id")
    for verb in (publish, listing, one, delete):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Carry out the verb."""
    asyncio.run(_VERBS[arguments.verb](arguments))
    return 0


async def _publish(arguments: argparse.Namespace) -> None:
    from robots.sim.map_file import read_map_files  # noqa: PLC0415 - reading YAML takes more than the base install

    yaml, image = read_map_files(arguments.yaml)
    map_id = arguments.id or arguments.yaml.stem
    client = logged_in(arguments)
    await client.upload_map(map_id, yaml, image, tuple(arguments.reader))
    show(await client.get(_path(map_id)), COLUMNS, as_json=arguments.json)


async def _list(arguments: argparse.Namespace) -> None:
    none = "no maps that you may use: ppaas map publish FILE.yaml"
    show(await logged_in(arguments).get("/v1/maps"), LIST_COLUMNS, as_json=arguments.json, if_none=none)


async def _show(arguments: argparse.Namespace) -> None:
    show(await logged_in(arguments).get(_path(arguments.id)), COLUMNS, as_json=arguments.json)


async def _delete(arguments: argparse.Namespace) -> None:
    await logged_in(arguments).delete(_path(arguments.id))


def _path(map_id: str) -> str:
    return f"/v1/maps/{quote(map_id, safe='')}"


_VERBS = {"publish": _publish, "list": _list, "show": _show, "delete": _delete}
