"""Command ``ppaas people``: people whom robots see on a map, who follows whom, and how many were seen."""

import argparse
import json
import sys
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.session import add_interval_argument, add_limit_argument, add_session_arguments, logged_in
from robots.cli.verbs.people_view import COUNT_COLUMNS, SETTINGS_COLUMNS, as_text, counts_for_people, render
from robots.client.rest_paths import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

NAME = "people"
HELP = "show the people whom your robots see on a map, choose whom they follow, and list how many were seen"

NOBODY = "-"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("map", help="id of the map")
    shown = parser.add_mutually_exclusive_group()
    shown.add_argument("--watch", action="store_true", help="show people until Ctrl-C")
    shown.add_argument("--history", action="store_true", help="list how many people were seen, by hour and zone")
    shown.add_argument("--settings", action="store_true", help="show the settings")
    shown.add_argument(
        "--put", type=Path, metavar="FILE.json", help="replace settings by a file, then apply other options"
    )
    shown.add_argument("--forget", action="store_true", help="remove all counts of the map")
    add_interval_argument(parser)
    chosen = parser.add_mutually_exclusive_group()
    chosen.add_argument(
        "--follow", nargs="+", metavar="PERSON", help=f"ids or names of people to follow, {NOBODY} for nobody"
    )
    chosen.add_argument("--rule", help="rule that chooses whom to follow: nearest, named, longest_seen")
    parser.add_argument("--name", action="append", metavar="ID=NAME", help="name a person; ID= removes the name")
    parser.add_argument("--followed-at-once", type=int, metavar="N", help="largest number of people who are followed")
    parser.add_argument("--count", choices=("on", "off"), help="count people by hour and zone, or not")
    parser.add_argument("--retention-hours", type=float, metavar="HOURS", help="time for which counts are kept")
    parser.add_argument("--zone", help="with --history: only this zone")
    add_limit_argument(parser)
    add_session_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Change what is to be changed, and show people, counts or settings."""
    event_loop.run(_run(arguments))
    return 0


async def _run(arguments: argparse.Namespace) -> None:
    client = logged_in(arguments)
    if arguments.put is not None:
        await client.put(path_of("maps", arguments.map, "people", "settings"), _read(arguments.put))
    changed = await _change(client, arguments)
    if arguments.forget:
        await client.delete(path_of("maps", arguments.map, "people", "history"))
    elif arguments.history:
        await _history(client, arguments)
    elif arguments.settings or arguments.put is not None or (changed and not arguments.watch):
        found = await client.get(path_of("maps", arguments.map, "people", "settings"))
        show(found if arguments.json else _for_people(found), SETTINGS_COLUMNS, as_json=arguments.json)
    elif arguments.watch and not arguments.json and sys.stdout.isatty():
        await _draw(client, arguments)
    else:
        async for seen in _updates(client, arguments):
            sys.stdout.write((json.dumps(seen) + "\n") if arguments.json else as_text(seen))
            sys.stdout.flush()


async def _change(client: "RestClient", arguments: argparse.Namespace) -> bool:
    """Send the changes of the arguments; return whether there are any."""
    change: dict[str, Any] = {
        "rule": arguments.rule,
        "followed_at_once": arguments.followed_at_once,
        "history": None if arguments.count is None else arguments.count == "on",
        "retention_hours": arguments.retention_hours,
        "names": None if arguments.name is None else dict(map(_name, arguments.name)),
    }
    change = {field: value for field, value in change.items() if value is not None}
    if change:
        await client.patch(path_of("maps", arguments.map, "people", "settings"), change)
    if arguments.follow is not None:
        people = [_person(text) for text in arguments.follow if text != NOBODY]
        await client.post(path_of("maps", arguments.map, "people", "follow"), {"people": people})
    return bool(change) or arguments.follow is not None


async def _history(client: "RestClient", arguments: argparse.Namespace) -> None:
    filters = {} if arguments.zone is None else {"zone": arguments.zone}
    found = await client.items(path_of("maps", arguments.map, "people", "history"), arguments.limit, **filters)
    none = "nobody was counted; counting is off unless you switch it on: ppaas people MAP --count on"
    show(found if arguments.json else counts_for_people(found), COUNT_COLUMNS, as_json=arguments.json, if_none=none)


async def _draw(client: "RestClient", arguments: argparse.Namespace) -> None:
    from rich.live import Live  # noqa: PLC0415 - ``ppaas --help`` loads this module

    with Live(screen=True, auto_refresh=False) as live:
        async for seen in _updates(client, arguments):
            live.update(render(seen), refresh=True)


async def _updates(client: "RestClient", arguments: argparse.Namespace) -> AsyncIterator[dict[str, Any]]:
    from asyncio import sleep  # noqa: PLC0415 - ``ppaas --help`` loads this module

    while True:
        yield await client.get(path_of("maps", arguments.map, "people"))
        if not arguments.watch:
            return
        await sleep(arguments.interval)


def _read(file: Path) -> Any:
    """Return the JSON of a file; ``InvalidInput`` if it cannot be read."""
    from ppaas.errors import InvalidInput  # noqa: PLC0415 - ``ppaas --help`` loads this module

    try:
        return json.loads(file.read_bytes())
    except (OSError, ValueError) as error:
        raise InvalidInput(f"cannot read settings from {file}: {error}") from error


def _person(text: str) -> int | str:
    return int(text) if text.isascii() and text.isdigit() else text


def _name(text: str) -> tuple[str, str | None]:
    """Return the id and the name of ``ID=NAME``; the name is None if it is empty.

    Raises
    ------
    InvalidInput
        The text has another form.
    """
    from ppaas.errors import InvalidInput  # noqa: PLC0415 - ``ppaas --help`` loads this module

    person, equals, name = text.partition("=")
    if not equals or not person:
        raise InvalidInput(f"{text!r} is not ID=NAME; name a person as 3=Zoë")
    return person, name or None


def _for_people(settings: dict[str, Any]) -> dict[str, Any]:
    return settings | {"zones": [zone["name"] for zone in settings["zones"]]}
