"""Verb ``ppaas robot map``: shows, saves and publishes the map that a robot makes."""

import argparse
import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.errors import InvalidInput, PPaaSError
from robots.cli.output import show
from robots.cli.progress import Report, progress_bar
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

COLUMNS = ("key_frames", "edges", "closures", "joined_with", "refused")

PUBLISHED = ("id", "version", "width", "height", "resolution", "origin")

TIMEOUT = 300.0
"""Time limit of a publication [s]: the map is refined and drawn."""

PERIOD = 0.5
"""Time between two requests for the progress of a publication [s]."""

STAGES = {
    "transfer": ("get the pose graph", 0.0, 0.0),
    "waiting": ("wait for other work", 0.05, 0.0),
    "loops": ("search for missing loops", 0.1, 0.6),
    "alignment": ("align all scans", 0.7, 0.0),
    "drawing": ("draw the map", 0.9, 0.0),
    "storing": ("store the map", 0.95, 0.0),
}
"""Stages of a publication: text, and the part of the bar at which it begins, and that it takes."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    parser.add_argument("id", help="id of a connected robot that makes a map")
    parser.add_argument("--publish", metavar="MAP", help="publish the map so far as this map; the robot goes on")
    parser.add_argument("--message", default="", help="with --publish: reason, stored with the version")
    parser.add_argument("--no-refine", action="store_true", help="with --publish: leave the key frames where they are")
    parser.add_argument("--posegraph", type=Path, metavar="FILE", help="write the pose graph of the map so far")
    add_session_arguments(parser)


async def run(arguments: argparse.Namespace) -> None:
    """Execute the verb."""
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads this module

    client, path = logged_in(arguments), path_of("robots", arguments.id, "map")
    if arguments.posegraph is not None:
        try:
            await client.fetch_to(path_of("robots", arguments.id, "map", "posegraph"), arguments.posegraph)
        except OSError as error:
            raise InvalidInput(f"cannot write {arguments.posegraph}: {error}") from error
    if arguments.publish is None:
        show(await client.get(path), COLUMNS, as_json=arguments.json)
        return
    wanted = {"publish": arguments.publish, "refine": not arguments.no_refine, "message": arguments.message}
    with progress_bar(f"publish {arguments.publish}") as report:
        watching = asyncio.create_task(_watch(client, path, report))
        try:
            published = await client.with_timeout(TIMEOUT).post(path, wanted)
        finally:
            watching.cancel()
            await asyncio.gather(watching, return_exceptions=True)
    show(published, PUBLISHED, as_json=arguments.json)


async def _watch(client: "RestClient", path: str, report: Report | None) -> None:
    """Report how far a publication is, until cancelled; without a terminal, do nothing."""
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads this module

    while report is not None:
        with contextlib.suppress(PPaaSError):  # the robot is away for a moment; the publication itself goes on
            publishing = (await client.get(path))["publishing"]
            if publishing is not None:
                text, begin, length = STAGES.get(publishing["stage"], (publishing["stage"], 0.0, 0.0))
                report(text, begin + length * publishing["part"])
        await asyncio.sleep(PERIOD)
