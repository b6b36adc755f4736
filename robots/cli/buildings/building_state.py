"""Verb ``ppaas building state``: what the lifts and doors of a building do, and the journeys in it."""

import argparse
import json
import sys
import time
from collections.abc import AsyncIterator
from typing import TYPE_CHECKING, Any

from robots.cli.output import printable, table
from robots.cli.session import add_interval_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

Row = dict[str, Any]

LIFTS = ("lift", "floor", "door", "motion", "mode", "target", "robots", "fault")
DOORS = ("door", "floor", "mode", "robots", "fault")
JOURNEYS = ("robot", "on", "to", "state", "leg", "began", "text")
UNKNOWN = "(another user's)"


def configure(verbs: Any) -> None:
    """Add the parser of the verb."""
    parser = verbs.add_parser(
        "state",
        help="show what the lifts and doors of a building do, who waits for them, and the journeys in it",
        description="The cloud connects to the lifts and doors for this, and stays connected for a minute.",
    )
    parser.add_argument("id", help="id of the building; OWNER:ID for one of another user")
    parser.add_argument("--watch", action="store_true", help="show the state until Ctrl-C")
    add_interval_argument(parser)
    add_session_arguments(parser)


async def show_state(arguments: argparse.Namespace) -> None:
    """Show the state of a building, once or until Ctrl-C."""
    client = logged_in(arguments)
    if arguments.watch and not arguments.json and sys.stdout.isatty():
        await _draw(client, arguments)
        return
    async for seen in _updates(client, arguments):
        sys.stdout.write((json.dumps(seen) + "\n") if arguments.json else as_text(seen))
        sys.stdout.flush()


async def _draw(client: "RestClient", arguments: argparse.Namespace) -> None:
    from rich.live import Live  # noqa: PLC0415 - a robot's install has no rich
    from rich.text import Text  # noqa: PLC0415

    with Live(screen=True, auto_refresh=False) as live:
        async for seen in _updates(client, arguments):
            live.update(Text(as_text(seen), no_wrap=True), refresh=True)


async def _updates(client: "RestClient", arguments: argparse.Namespace) -> AsyncIterator[Row]:
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads this module

    while True:
        yield await client.get(path_of("buildings", arguments.id, "state"))
        if not arguments.watch:
            return
        await asyncio.sleep(arguments.interval)


def as_text(seen: Row) -> str:
    """Return the state of a building as plain text."""
    parts = [
        _part("no lifts with a device", [_lift(lift) for lift in seen["lifts"]], LIFTS),
        _part("no doors with a device", [_door(door) for door in seen["doors"]], DOORS),
        _part("no journeys", [_journey(journey) for journey in seen["journeys"]], JOURNEYS),
        [f"fault: {printable(fault)}" for fault in seen["faults"]],
    ]
    return "\n".join(line for part in parts if part for line in (*part, "")) + "\n"


def _part(if_none: str, rows: list[Row], columns: tuple[str, ...]) -> list[str]:
    return table(rows, columns) if rows else [if_none]


def _lift(lift: Row) -> Row:
    robots = [
        f"{ride['robot'] or UNKNOWN} {ride['phase']} {ride['origin']}-{ride['destination']}" for ride in lift["rides"]
    ]
    return {**lift, "floor": lift["floor"] or None, "target": lift["target"] or None, "robots": robots, **_fault(lift)}


def _door(door: Row) -> Row:
    return {**door, "robots": [robot or UNKNOWN for robot in door["robots"]], **_fault(door)}


def _journey(journey: Row) -> Row:
    is_active = journey["state"] == "active"
    return {
        "robot": journey["robot"] or UNKNOWN,
        "on": journey["on"],
        "to": journey["floor"],
        "state": journey["phase"] if is_active else journey["state"],
        "leg": (is_active and journey["leg"]) or None,
        "began": time.strftime("%H:%M:%S", time.localtime(journey["since"])),
        "text": journey["text"] or None,
    }


def _fault(part: Row) -> Row:
    return {"fault": part["fault"] or None}
