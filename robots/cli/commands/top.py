"""Command ``ppaas top``: live view of the machines and containers."""

import argparse
import contextlib
import json
import sys
from collections.abc import AsyncIterator, Callable
from typing import TYPE_CHECKING, Any

from ppaas.clock import epoch
from ppaas.errors import NotPermitted
from robots.cli import event_loop
from robots.cli.session import add_interval_argument, add_session_arguments, logged_in
from robots.cli.verbs.top_view import SORT_KEYS, as_text, render
from robots.client.rest_paths import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

NAME = "top"
HELP = "watch the machines and containers, and what they use"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("--once", action="store_true", help="show them once and exit")
    add_interval_argument(parser)
    parser.add_argument("--sort", choices=SORT_KEYS, default="cpu", help="sort key (%(default)s)")
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
    """Return the current ``time``, ``machines`` (None if the user is not an administrator) and ``containers``."""
    machines = None
    with contextlib.suppress(NotPermitted):
        machines = await client.items(path_of("machines"))
    return {"time": epoch(), "machines": machines, "containers": await client.items(path_of("containers"))}
