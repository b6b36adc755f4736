"""Command ``ppaas building``: buildings of several floors, and where their lifts, doors, ways and docks are."""

import argparse
import json
from pathlib import Path
from typing import Any

from ppaas.errors import InvalidInput
from robots.cli import event_loop
from robots.cli.buildings import building_import, building_plan, building_state
from robots.cli.buildings.building_plan import draw_floors
from robots.cli.map_files.publication import NOBODY
from robots.cli.output import print_warnings, show
from robots.cli.output_files import write_file
from robots.cli.resource import Resource
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

NAME = "building"
HELP = "put, list, check, share, lay out, watch, import and remove buildings of several floors"

ROOT = "buildings"
COLUMNS = ("id", "owner", "version", "floors", "readers", "created", "author", "message")
BUILDINGS = Resource(
    ROOT, COLUMNS, "no buildings; put one: ppaas building put ID FILE, or import one: ppaas building import FILE"
)
CHECKED = ("floors", "lifts", "ways", "doors", "docks")
VERSIONS = ("version", "created", "author", "message", "present")
PLACES = ("kind", "name", "floor", "place", "detail")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    listing = verbs.add_parser("list", help="list the buildings that you may read")
    add_limit_argument(listing)
    named = {
        "show": "show a building, or write it to a file",
        "versions": "list the versions of a building, newest first",
        "put": "put a building, or a new version of it",
        "check": "check a building as if it were put, and change nothing",
        "share": "name the other users who may read a building",
        "layout": "list the lifts, doors, ways and docks on each floor, or draw them",
        "remove": "remove a building with its versions; its maps stay",
    }
    each = {name: verbs.add_parser(name, help=text) for name, text in named.items()}
    for verb in each.values():
        verb.add_argument("id", help="id of the building; OWNER:ID for one of another user")
    each["show"].add_argument("--version", type=int, metavar="N", help="version (the current one)")
    each["show"].add_argument("--out", type=Path, metavar="FILE", help="write what put takes to a file of JSON")
    for name in ("put", "check"):
        each[name].add_argument("file", type=Path, metavar="FILE", help="JSON: floors, lifts, doors, ways")
    each["put"].add_argument("--message", default="", help="reason, stored with the version")
    for name in ("put", "remove"):
        each[name].add_argument("--if-match", metavar="N", help="change only if this is the current version")
    each["share"].add_argument(
        "--reader", action="append", required=True, help=f"a user; * for everybody, {NOBODY} for nobody"
    )
    each["layout"].add_argument("--picture", type=Path, metavar="FILE.png", help="draw all floors side by side")
    for verb in (listing, *each.values()):
        add_session_arguments(verb)
    building_state.configure(verbs)
    building_plan.configure(verbs)
    building_import.configure(verbs)


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


async def _show(arguments: argparse.Namespace) -> None:
    version = "" if arguments.version is None else f"?version={arguments.version}"
    found = await logged_in(arguments).get(path_of(ROOT, arguments.id) + version)
    if arguments.out is not None:
        write_file(arguments.out, json.dumps(found["building"], indent=2, ensure_ascii=False).encode() + b"\n")
    else:
        show(found, COLUMNS, as_json=arguments.json)


async def _versions(arguments: argparse.Namespace) -> None:
    found = await logged_in(arguments).get(path_of(ROOT, arguments.id, "versions"))
    show(found, VERSIONS, as_json=arguments.json)


async def _put(arguments: argparse.Namespace) -> None:
    content = _read(arguments.file)
    answer = await logged_in(arguments).put_building(arguments.id, content, arguments.message, arguments.if_match)
    show(answer, COLUMNS, as_json=arguments.json)
    if not arguments.json:
        print_warnings(answer)


async def _check(arguments: argparse.Namespace) -> None:
    answer = await logged_in(arguments).check_building(arguments.id, _read(arguments.file))
    show(answer, CHECKED, as_json=arguments.json)
    if not arguments.json:
        print_warnings(answer)


async def _share(arguments: argparse.Namespace) -> None:
    readers = [name for name in arguments.reader if name != NOBODY]
    changed = await logged_in(arguments).patch(path_of(ROOT, arguments.id), {"readers": readers})
    show(changed, COLUMNS, as_json=arguments.json)


async def _remove(arguments: argparse.Namespace) -> None:
    await logged_in(arguments).remove_building(arguments.id, arguments.if_match)


async def _layout(arguments: argparse.Namespace) -> None:
    if arguments.picture is not None:
        from robots.pictures.path import check_picture  # noqa: PLC0415 - pictures need more than the base install

        check_picture(arguments.picture)
    client = logged_in(arguments)
    found = await client.get(path_of(ROOT, arguments.id, "layout"))
    if arguments.picture is not None:
        await draw_floors(client, arguments.picture, found["floors"])
    if arguments.json:
        show(found, PLACES, as_json=True)
        return
    show(_places(found), PLACES, as_json=False, if_none="no lifts, doors, ways or docks: draw them as zones")
    print_warnings(found)


def _places(layout: dict[str, Any]) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    for lift, landings in layout["lifts"].items():
        for one in landings:
            rows.append(_row("lift", lift, one["floor"], one["wait"], f"door {one['door']}"))
    for way, ends in layout["ways"].items():
        rows += [_row("way", way, end["floor"], end["place"]) for end in ends]
    for door in layout["doors"]:
        (x0, y0), (x1, y1) = door["ends"]
        lift = f"of lift {door['lift']}" if door["lift"] else None
        rows.append(_row("door", door["door"], door["floor"], [0.5 * (x0 + x1), 0.5 * (y0 + y1)], lift))
    for dock in layout["docks"]:
        charges = "charges" if dock["charges"] else None
        rows.append(_row("dock", dock["dock"], dock["floor"], dock["place"], charges))
    return rows


def _row(kind: str, name: str, floor: str, place: list[float], detail: str | None = None) -> dict[str, Any]:
    return {"kind": kind, "name": name, "floor": floor, "place": [round(each, 2) for each in place], "detail": detail}


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read {file}: {error.strerror}") from error


_VERBS = {
    "list": BUILDINGS.list,
    "show": _show,
    "versions": _versions,
    "put": _put,
    "check": _check,
    "share": _share,
    "layout": _layout,
    "remove": _remove,
    "state": building_state.show_state,
    "plan": building_plan.plan_over_floors,
    "import": building_import.import_building_file,
}
