"""Command ``ppaas top``: live view of machines, containers and robots, as tables for a terminal or as plain text."""

import argparse
import contextlib
import io
import json
import sys
import time
from collections.abc import AsyncIterator, Callable
from typing import TYPE_CHECKING, Any

from ppaas.clock import epoch
from ppaas.errors import NotPermitted
from robots.cli import event_loop
from robots.cli.output import cell, duration, percent, size, table
from robots.cli.session import add_interval_argument, add_session_arguments, logged_in
from robots.cli.verbs.robot_list import COLUMNS, in_order, short
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from rich.console import Group

    from robots.client.rest import RestClient


Row = dict[str, Any]

MACHINES = ("id", "state", "cores", "capacity", "load", "memory_used", "memory", "containers", "kernels")
CONTAINERS = (
    "id", "kind", "user", "robot", "map", "machine", "state", "connected", "cores", "cpu", "pss", "age", "clients",
)  # fmt: skip
ROBOTS = COLUMNS
NUMBERS = frozenset(MACHINES[2:] + CONTAINERS[8:]) | {"battery", "seen_ago"}


SORT_KEYS: dict[str, Callable[[Row], Any]] = {
    "cpu": lambda row: -(row["cpu"] or 0.0),
    "memory": lambda row: -(row["pss"] or 0),
    "age": lambda row: -row["age"],
    "robot": lambda row: (row["robot"] or "", row["user"]),
    "id": lambda row: (len(row["id"]), row["id"]),
}


def as_text(seen: Row, sort: str) -> str:
    """Return the view as plain text."""
    text = io.StringIO()
    text.write(heading(seen) + "\n")
    for columns, rows in _tables(seen, sort):
        if rows:
            text.write("\n" + "\n".join(table(rows, columns)) + "\n")
    return text.getvalue()


def render(seen: Row, sort: str) -> "Group":
    """Return the view as an object that rich draws."""
    from rich import box  # noqa: PLC0415 - a robot's install has no rich
    from rich.console import Group  # noqa: PLC0415
    from rich.table import Table  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    drawn: list[Any] = [Text(heading(seen), style="bold"), ""]
    for columns, rows in _tables(seen, sort):
        grid = Table(box=box.SIMPLE_HEAD, expand=True, pad_edge=False)
        for column in columns:
            grid.add_column(column, justify="right" if column in NUMBERS else "left", no_wrap=True)
        for row in rows:
            grid.add_row(*(Text(cell(column, row.get(column))) for column in columns))
        drawn.append(grid)
    return Group(*drawn)


def heading(seen: Row) -> str:
    """Return the first line: the time and the totals."""
    containers = seen["containers"]
    robots = sum(one["connected"] for one in containers)
    cpu, memory = (sum(one[key] or 0 for one in containers) for key in ("cpu", "pss"))
    oldest = max((one["age"] for one in containers), default=0.0)
    return (
        f"{time.strftime('%H:%M:%S', time.localtime(seen['time']))}  {robots} robots connected  "
        f"{len(containers)} containers  CPU {percent(cpu)}  memory {size(memory)}  oldest {duration(oldest)}"
    )


def _tables(seen: Row, sort: str) -> list[tuple[tuple[str, ...], list[Row]]]:
    containers = sorted(seen["containers"], key=SORT_KEYS.get(sort, SORT_KEYS["cpu"]))
    robots = in_order(seen["robots"], sort if sort in ROBOTS else "id")
    return [(MACHINES, seen["machines"] or []), (CONTAINERS, containers), (ROBOTS, list(map(short, robots)))]


NAME = "top"
HELP = "watch the machines, containers and robots"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("--once", action="store_true", help="show them once and exit")
    add_interval_argument(parser)
    keys = [*SORT_KEYS, *(column for column in ROBOTS if column not in SORT_KEYS)]
    parser.add_argument("--sort", choices=keys, default="cpu", help="sort key, of containers or robots (%(default)s)")
    add_session_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Show the view until Ctrl-C: live on a terminal, otherwise as successive texts or lines of JSON."""
    client = logged_in(arguments)
    if arguments.json:
        event_loop.run(_print(client, arguments, json.dumps))
    elif arguments.once or not sys.stdout.isatty():
        event_loop.run(_print(client, arguments, lambda seen: as_text(seen, arguments.sort)))
    else:
        event_loop.run(_draw(client, arguments))
    return 0


async def _print(client: "RestClient", arguments: argparse.Namespace, render_text: Callable[[Any], str]) -> None:
    async for seen in _updates(client, arguments):
        sys.stdout.write(render_text(seen) + "\n")
        sys.stdout.flush()


async def _draw(client: "RestClient", arguments: argparse.Namespace) -> None:
    from rich.live import Live  # noqa: PLC0415 - ``ppaas --help`` loads this module

    with Live(screen=True, auto_refresh=False) as live:
        async for seen in _updates(client, arguments):
            live.update(render(seen, arguments.sort), refresh=True)


async def _updates(client: "RestClient", arguments: argparse.Namespace) -> AsyncIterator[dict[str, Any]]:
    from asyncio import sleep  # noqa: PLC0415 - ``ppaas --help`` loads this module

    while True:
        yield await read_state(client)
        if arguments.once:
            return
        await sleep(arguments.interval)


async def read_state(client: "RestClient") -> dict[str, Any]:
    """Return the ``time``, ``machines`` (None for other users than administrators), ``containers`` and ``robots``."""
    machines = None
    with contextlib.suppress(NotPermitted):
        machines = await client.items(path_of("machines"))
    robots = await client.items(path_of("robots"))
    shared = await client.items(path_of("robots"), shared="true")
    robots += [robot | {"id": f"{robot['user']}:{robot['id']}"} for robot in shared]
    containers = await client.items(path_of("containers"))
    return {"time": epoch(), "machines": machines, "containers": containers, "robots": robots}
