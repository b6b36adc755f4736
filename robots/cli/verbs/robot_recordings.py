"""Verbs ``ppaas robot record`` and ``recordings``: record a robot, and fetch recordings and the last minutes."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import Conflict, InvalidInput
from robots.cli.output import show
from robots.cli.output_files import check_folder
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

COLUMNS = ("id", "size", "finished")

STATE = ("recording", "left", "ring_minutes", "messages", "lost", "problem")

RING = "ring"
"""Name of the ring in place of the id of a recording."""

LONGEST = 3600.0
"""Longest recording [s]."""

TIMEOUT = 300.0
"""Time limit of a download [s]."""

LOOK = 1.0
"""Period at which the recorder is asked whether it still records [s]."""


def configure_record(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``record``."""
    parser.add_argument("id", help="id of a connected robot; OWNER:ID for one of another user")
    parser.add_argument(
        "--seconds", type=_seconds, help="stop after this time (at Ctrl-C or SIGTERM, and after an hour)"
    )
    parser.add_argument(
        "--topic", action="append", default=[], metavar="GLOB", help="topics to record; may be repeated (robot file)"
    )
    parser.add_argument("--ring", action="store_true", help="fetch the last minutes, which the robot file keeps")
    parser.add_argument("--minutes", type=float, help="with --ring: only so many (all)")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="file to write (ROBOT-ID.mcap)")
    add_session_arguments(parser)


def configure_recordings(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``recordings``."""
    parser.add_argument("id", help="id of the robot; OWNER:ID for one of another user")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--get", metavar="RECORDING", help="fetch this recording")
    what.add_argument("--delete", metavar="RECORDING", help="delete this recording; 'ring' for the last minutes")
    what.add_argument("--state", action="store_true", help="show what the recorder does, and its problem")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="with --get: file to write (ROBOT-ID.mcap)")
    add_limit_argument(parser)
    add_session_arguments(parser)


async def record(arguments: argparse.Namespace) -> None:
    """Record a robot and fetch the file, or fetch the last minutes."""
    client = logged_in(arguments)
    if arguments.output is not None:
        check_folder(arguments.output)
    if arguments.ring:
        query = "" if arguments.minutes is None else f"?minutes={arguments.minutes:g}"
        await _fetch(client, arguments, RING, query)
        return
    path = path_of("robots", arguments.id, "recordings")
    wanted: dict[str, Any] = {"seconds": arguments.seconds or LONGEST}
    if arguments.topic:
        wanted["topics"] = arguments.topic
    recording, problem = await _recorded(client, arguments, wanted)
    await client.post(f"{path}/{recording}/stop", {})
    await _fetch(client, arguments, recording)
    if problem:
        raise Conflict(f"the recording ended early: {problem}")


async def recordings(arguments: argparse.Namespace) -> None:
    """List the recordings of a robot, or fetch or delete one."""
    client, path = logged_in(arguments), path_of("robots", arguments.id, "recordings")
    if arguments.get is not None:
        await _fetch(client, arguments, arguments.get)
    elif arguments.delete is not None:
        await client.delete(f"{path}/{arguments.delete}")
    elif arguments.state:
        show(await client.get(path_of("robots", arguments.id, "recorder")), STATE, as_json=arguments.json)
    else:
        found = await client.items(path, arguments.limit)
        show(found, COLUMNS, as_json=arguments.json, if_none="no recordings; record: ppaas robot record ID")


async def _recorded(client: "RestClient", arguments: argparse.Namespace, wanted: dict[str, Any]) -> tuple[str, str]:
    """Start a recording; return it and its problem when it ends, or at Ctrl-C or SIGTERM, which cancel the task.

    A second signal ends the command.
    """
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads this module

    task = asyncio.current_task()
    assert task is not None
    starting = asyncio.create_task(client.post(path_of("robots", arguments.id, "recordings"), wanted))
    try:
        recording = (await asyncio.shield(starting))["id"]
        return recording, await _wait(client, arguments, recording)
    except asyncio.CancelledError:
        task.uncancel()
        return (await starting)["id"], ""


async def _wait(client: "RestClient", arguments: argparse.Namespace, recording: str) -> str:
    """Wait until the time is over, or the recorder ends by itself; return its problem, or an empty text."""
    import asyncio  # noqa: PLC0415

    loop = asyncio.get_running_loop()
    until = loop.time() + (arguments.seconds or LONGEST)
    sys.stderr.write(f"recording {arguments.id} as {recording}{'' if arguments.seconds else ', until Ctrl-C'}\n")
    while loop.time() < until:
        await asyncio.sleep(min(LOOK, until - loop.time()))
        state = await client.get(path_of("robots", arguments.id, "recorder"))
        if state["recording"] != recording:
            return str(state["problem"])
    return ""


async def _fetch(client: "RestClient", arguments: argparse.Namespace, recording: str, query: str = "") -> None:
    target = arguments.output or Path(f"{arguments.id.replace(':', '-')}-{recording}.mcap")
    path = path_of("robots", arguments.id, "recordings", recording, "file")
    try:
        await client.with_timeout(TIMEOUT).fetch_to(f"{path}{query}", target)
        size = target.stat().st_size
    except OSError as error:
        raise InvalidInput(f"cannot write {target}: {error}") from error
    sys.stderr.write(f"{target}: {size / 1e6:.2f} MB\n")


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0.0 < seconds <= LONGEST:
        raise argparse.ArgumentTypeError(f"must be more than 0 and at most {LONGEST:g} seconds, not {text}")
    return seconds
