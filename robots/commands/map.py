"""``ppaas map``: publish, list, show, change, fetch and delete maps."""

import argparse
import asyncio
import sys
from pathlib import Path
from typing import Any

from ppaas.errors import InvalidInput
from robots.commands.resource import Resource
from robots.commands.session import add_limit_argument, add_session_arguments, logged_in
from robots.commands.table import show
from robots.rest_paths import path_of

NAME = "map"
HELP = "publish, list, show, change, fetch and delete maps"

MAPS = Resource(
    "maps",
    ("id", "owner", "version", "width", "height", "resolution", "origin", "readers", "description"),
    "no maps that you may use: ppaas map publish FILE.yaml",
    list_columns=("id", "owner", "version", "created", "readers", "description"),
)
VERSIONS = ("version", "created", "present")
NOBODY = "-"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    publish = verbs.add_parser("publish", help="publish a map of map_server, or its new version")
    publish.add_argument("yaml", type=Path, help="its YAML file; the image is found by it")
    publish.add_argument("--id", help="of the map (the name of the YAML file)")
    publish.add_argument(
        "--rules", choices=("map_server", "nav2"), help="what is free (as the file says, or map_server)"
    )
    listing = verbs.add_parser("list", help="list the maps that you may use")
    one = verbs.add_parser("show", help="show one map")
    change = verbs.add_parser("change", help="change who may use a map, or what is said of it")
    versions = verbs.add_parser("versions", help="list the versions that a map had")
    fetch = verbs.add_parser("fetch", help="fetch the files of a map")
    delete = verbs.add_parser("delete", help="delete a map with all its versions")
    for verb in (one, change, versions, fetch, delete):
        verb.add_argument("id")
    for verb in (publish, change):
        verb.add_argument("--reader", action="append", help=f"who else may use it; * is everybody, {NOBODY} nobody")
        verb.add_argument("--description", help="what it shows")
    for verb in (one, fetch):
        verb.add_argument("--version", help="another than the present one, as 'ppaas map versions --json' tells it")
    fetch.add_argument("--to", type=Path, default=Path(), metavar="FOLDER", help="where to put them (here)")
    for verb in (listing, versions):
        add_limit_argument(verb)
    for verb in (publish, listing, one, change, versions, fetch, delete):
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
    readers = tuple("" if name == NOBODY else name for name in arguments.reader or ())
    said = {"description": arguments.description, "rules": arguments.rules}
    await client.upload_map(map_id, yaml, image, readers, **said)
    show(await client.get(path_of("maps", map_id)), MAPS.columns, as_json=arguments.json)


async def _show(arguments: argparse.Namespace) -> None:
    path = path_of("maps", arguments.id, *_version(arguments))
    show(await logged_in(arguments).get(path), MAPS.columns, as_json=arguments.json)


async def _change(arguments: argparse.Namespace) -> None:
    change: dict[str, Any] = {}
    if arguments.reader is not None:
        change["readers"] = [name for name in arguments.reader if name != NOBODY]
    if arguments.description is not None:
        change["description"] = arguments.description
    if not change:
        raise InvalidInput("nothing to change: give --reader or --description")
    changed = await logged_in(arguments).patch(path_of("maps", arguments.id), change)
    show(changed, MAPS.list_columns, as_json=arguments.json)


async def _versions(arguments: argparse.Namespace) -> None:
    found = await logged_in(arguments).items(path_of("maps", arguments.id, "versions"), arguments.limit)
    show(found, VERSIONS, as_json=arguments.json)


async def _fetch(arguments: argparse.Namespace) -> None:
    from robots.sim.map_file import write_map_files  # noqa: PLC0415 - reading YAML takes more than the base install

    client, version = logged_in(arguments), _version(arguments)
    yaml, image = [await client.fetch(path_of("maps", arguments.id, *version, kind)) for kind in ("yaml", "image")]
    written = write_map_files(arguments.to, arguments.id, yaml, image)
    if arguments.json:
        show([str(path) for path in written], (), as_json=True)
    else:
        sys.stdout.writelines(f"{path}\n" for path in written)


def _version(arguments: argparse.Namespace) -> tuple[str, ...]:
    return () if arguments.version is None else ("versions", arguments.version)


_VERBS = {
    "publish": _publish,
    "list": MAPS.list,
    "show": _show,
    "change": _change,
    "versions": _versions,
    "fetch": _fetch,
    "delete": MAPS.delete,
}
