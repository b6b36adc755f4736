"""Command ``ppaas people``: people whom robots see on a map, who follows whom, and how many were seen."""

import argparse
import io
import json
import sys
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robots.cli import event_loop
from robots.cli.output import cell, duration, show, table
from robots.cli.session import add_interval_argument, add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from rich.console import Group

    from robots.client.rest import RestClient


Row = dict[str, Any]

PEOPLE = ("id", "name", "state", "x", "y", "speed", "seen", "group", "seen_by", "followed_by", "reason")
ROBOTS = ("robot", "x", "y", "deviation", "sees", "follows", "trusted", "reason")
NUMBERS = frozenset({"id", "x", "y", "speed", "seen", "deviation", "sees"})
COUNT_COLUMNS = ("hour", "zone", "people")
SETTINGS_COLUMNS = ("rule", "targets", "followed_at_once", "names", "zones", "history", "retention_hours")
WHOLE_MAP = "(whole map)"


def as_text(seen: Row) -> str:
    """Return the people of a map as plain text."""
    text = io.StringIO()
    text.write(heading(seen) + "\n")
    for columns, rows in _tables(seen):
        if rows:
            text.write("\n" + "\n".join(table(rows, columns)) + "\n")
    return text.getvalue()


def render(seen: Row) -> "Group":
    """Return the people of a map as an object that rich draws."""
    from rich import box  # noqa: PLC0415 - a robot's install has no rich
    from rich.console import Group  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    drawn: list[Any] = [Text(heading(seen), style="bold"), ""]
    for columns, rows in _tables(seen):
        grid = Table(box=box.SIMPLE_HEAD, expand=True, pad_edge=False)
        for column in columns:
            grid.add_column(column, justify="right" if column in NUMBERS else "left", no_wrap=column != "reason")
        for row in rows:
            grid.add_row(*(Text(cell(column, row[column])) for column in columns))
        drawn.append(grid)
    return Group(*drawn)


def heading(seen: Row) -> str:
    """Return the first line: the map, the number of people and the rule; or why there is no coordinator."""
    if seen["coordinator"] != "ready":
        return f"{seen['map']}  no people are tracked: {seen['reason'] or 'the coordinator is starting'}"
    count, following = seen["count"], len(seen["following"])
    people = "person" if count == 1 else "people"
    now = time.strftime("%H:%M:%S", time.localtime(seen["at"]))
    return f"{now}  {seen['map']}  {count} {people}  {following} followed (rule {seen['rule']})"


def counts_for_people(counts: list[Row]) -> list[Row]:
    """Return counts with local times, and a name for the whole map."""
    return [
        count
        | {
            "hour": time.strftime("%Y-%m-%d %H:%M", time.localtime(count["hour"])),
            "zone": count["zone"] or WHOLE_MAP,
        }
        for count in counts
    ]


def _tables(seen: Row) -> list[tuple[tuple[str, ...], list[Row]]]:
    orders = {order["person"]: order for order in seen["following"]}
    follows = {order["robot"]: order["person"] for order in seen["following"]}
    people = [_person_row(person, orders.get(person["id"]), seen["at"]) for person in seen["people"]]
    robots = [_robot(robot, follows.get(robot["robot"])) for robot in seen["robots"]]
    return [(PEOPLE, people), (ROBOTS, robots)]


def _person_row(person: Row, order: Row | None, now: float) -> Row:
    x, y = person["position"]
    speed = sum(part**2 for part in person["velocity"]) ** 0.5
    return person | {
        "name": person["name"] or None,
        "x": f"{x:.2f}",
        "y": f"{y:.2f}",
        "speed": f"{speed:.1f}",
        "seen": duration(max(0.0, now - person["last_seen"])),
        "group": person["group"] or None,
        "followed_by": order["robot"] if order else None,
        "reason": order["reason"] if order else None,
    }


def _robot(robot: Row, follows: int | None) -> Row:
    x, y = (None, None) if robot["position"] is None else (f"{place:.2f}" for place in robot["position"])
    deviation = None if robot["deviation"] is None else f"{robot['deviation']:.2f}"
    return robot | {"x": x, "y": y, "deviation": deviation, "follows": follows, "reason": robot["reason"] or None}


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
