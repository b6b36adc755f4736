"""Command ``ppaas explore ROBOT``: lets a robot that makes a map explore, with progress."""

import argparse
from typing import TYPE_CHECKING, Any

from ppaas.errors import Conflict, Unavailable
from ppaas.maps.new_map import NEW
from robots.cli import event_loop
from robots.cli.output import print_line, show
from robots.cli.session import add_session_arguments, logged_in, token_of
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.explore import ExploreOutcome

NAME = "explore"
HELP = "let a robot that makes a map drive to its frontiers until none is left"

COLUMNS = ("state", "text", "frontiers", "unreachable", "area", "distance", "seconds")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("id", help="id of the robot")
    parser.add_argument("--return-to-start", action="store_true", help="drive back when no frontier is left")
    parser.add_argument(
        "--anyway",
        action="store_true",
        help="even if the robot file names a published map by now",
    )
    add_session_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Explore until no frontier is left; Ctrl-C cancels."""
    event_loop.run(_run(arguments))
    return 0


async def _run(arguments: argparse.Namespace) -> None:
    from ppaas.messages.actionlib_msgs import Status  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from robots.cli.explore_progress import ExploreProgress  # noqa: PLC0415
    from robots.client.explore import ExploreClient  # noqa: PLC0415
    from robots.client.robot_client import RobotClient  # noqa: PLC0415

    await _check(arguments)
    progress = None if arguments.json else ExploreProgress(print_line)
    async with RobotClient(
        arguments.url, robot=arguments.id, token=token_of(arguments), role="operator", hold=False
    ) as client:
        outcome = await ExploreClient(client, progress).explore(return_to_start=arguments.return_to_start)
    show(as_json(outcome), COLUMNS, as_json=arguments.json)
    if outcome.status is not Status.SUCCEEDED:
        raise Unavailable(f"the robot has not explored everything: {outcome.text or outcome.status.name.lower()}")


async def _check(arguments: argparse.Namespace) -> None:
    """Check that the robot makes a map and is connected.

    Raises
    ------
    Conflict
        It drives on a published map.
    Unavailable
        It is not connected.
    """
    client, robot = logged_in(arguments), arguments.id
    used = (await client.get(path_of("robots", robot)))["map"]
    if not used.startswith(NEW) and not arguments.anyway:
        raise Conflict(
            f"robot {robot!r} drives on the published map {used!r}: there is nothing to explore. To let it make a map: "
            f"ppaas robot change {robot} map={NEW}NAME, and connect the robot again"
        )
    if not (await client.get(path_of("robots", robot, "state")))["connected"]:
        raise Unavailable(f"robot {robot!r} is not connected: start it, and explore again")


def as_json(outcome: "ExploreOutcome") -> dict[str, Any]:
    """Return an outcome as an object of JSON."""
    result = outcome.result
    return {
        "state": outcome.status.name.lower(),
        "text": outcome.text,
        "frontiers": result.frontiers,
        "unreachable": result.unreachable,
        "area": round(result.area, 2),
        "distance": round(result.distance, 2),
        "seconds": round(result.exploration_time.seconds(), 1),
    }
