"""Verb ``ppaas robot map``: shows, saves and publishes the map that a robot makes."""

import argparse
from pathlib import Path

from ppaas.errors import InvalidInput
from robots.cli.output import show
from robots.cli.session import add_session_arguments, logged_in
from robots.client.rest_paths import path_of

COLUMNS = ("key_frames", "edges", "closures", "joined_with", "refused")

PUBLISHED = ("id", "version", "width", "height", "resolution", "origin")

TIMEOUT = 300.0
"""Time limit of a publication [s]: the map is refined and drawn."""


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
    show(await client.with_timeout(TIMEOUT).post(path, wanted), PUBLISHED, as_json=arguments.json)
