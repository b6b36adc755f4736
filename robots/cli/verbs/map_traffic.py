"""Verb ``ppaas map traffic``: shows the traffic of your robots on a map, takes robots out of it and puts them back."""

import argparse
import json
import sys
import time
from collections.abc import AsyncIterator
from typing import TYPE_CHECKING, Any

from robots.cli.output import cell, duration, table
from robots.cli.session import add_interval_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from rich.console import Group

    from robots.client.rest import RestClient

Row = dict[str, Any]

COLUMNS = ("robot", "state", "waits_for", "waited", "goal", "x", "y", "cells")
NUMBERS = frozenset({"waited", "x", "y", "cells"})


def configure(verbs: Any) -> None:
    """Add the parser of the verb."""
    traffic = verbs.add_parser(
        "traffic",
        help="show the traffic of your robots on a map: who drives, who waits for whom, what each holds",
        description="The column 'cells' has the number of cells that a robot holds; --json prints where they are.",
    )
    traffic.add_argument("id")
    change = traffic.add_mutually_exclusive_group()
    change.add_argument(
        "--take-out",
        metavar="ROBOT",
        help="first take out a robot that has broken down: what it holds is free, and others drive where it stood",
    )
    change.add_argument("--put-back", metavar="ROBOT", help="first put back a robot that was taken out")
    traffic.add_argument("--watch", action="store_true", help="show the traffic until Ctrl-C")
    add_interval_argument(traffic)
    add_session_arguments(traffic)


async def traffic(arguments: argparse.Namespace) -> None:
    """Take a robot out or put it back, if asked to, and show the traffic."""
    client = logged_in(arguments)
    for change in ("take_out", "put_back"):
        robot = getattr(arguments, change)
        if robot is not None:
            await client.post(path_of("maps", arguments.id, "traffic", "robots", robot, change), {})
    if arguments.watch and not arguments.json and sys.stdout.isatty():
        await _draw(client, arguments)
        return
    async for seen in _updates(client, arguments):
        sys.stdout.write((json.dumps(seen) + "\n") if arguments.json else as_text(seen))
        sys.stdout.flush()


async def _draw(client: "RestClient", arguments: argparse.Namespace) -> None:
    from rich.live import Live  # noqa: PLC0415 - ``ppaas --help`` loads this module

    with Live(screen=True, auto_refresh=False) as live:
        async for seen in _updates(client, arguments):
            live.update(render(seen), refresh=True)


async def _updates(client: "RestClient", arguments: argparse.Namespace) -> AsyncIterator[Row]:
    from asyncio import sleep  # noqa: PLC0415 - ``ppaas --help`` loads this module

    while True:
        yield await client.get(path_of("maps", arguments.id, "traffic"))
        if not arguments.watch:
            return
        await sleep(arguments.interval)


def as_text(seen: Row) -> str:
    """Return the traffic of a map as plain text."""
    return "\n".join([heading(seen), "", *table(_rows(seen), COLUMNS), ""])


def render(seen: Row) -> "Group":
    """Return the traffic of a map as an object that rich draws."""
    from rich import box  # noqa: PLC0415 - a robot's install has no rich
    from rich.console import Group  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    grid = Table(box=box.SIMPLE_HEAD, expand=True, pad_edge=False)
    for column in COLUMNS:
        grid.add_column(column, justify="right" if column in NUMBERS else "left", no_wrap=column != "waits_for")
    for row in _rows(seen):
        grid.add_row(*(Text(cell(column, row[column])) for column in COLUMNS))
    return Group(Text(heading(seen), style="bold"), "", grid)


def heading(seen: Row) -> str:
    """Return the first line: the time, the map, the number of robots and of those that wait, and the goals reached."""
    robots = seen["robots"]
    waiting = sum(robot["state"] == "waiting" for robot in robots)
    noun = "robot" if len(robots) == 1 else "robots"
    now = time.strftime("%H:%M:%S", time.localtime(seen["at"]))
    return f"{now}  {seen['map']}  {len(robots)} {noun}  {waiting} waiting  {seen['goals']} goals reached"


def _rows(seen: Row) -> list[Row]:
    return [_row(robot) for robot in seen["robots"]]


def _row(robot: Row) -> Row:
    x, y, _ = robot["pose"]
    waits = bool(robot["waits_for"])
    return {
        "robot": robot["robot"],
        "state": robot["state"],
        "waits_for": robot["waits_for"] or None,
        "waited": duration(robot["waited"]) if waits else None,
        "goal": None if robot["goal"] is None else ", ".join(f"{part:.2f}" for part in robot["goal"]),
        "x": f"{x:.2f}",
        "y": f"{y:.2f}",
        "cells": len(robot["way"]),
    }
