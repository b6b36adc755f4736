"""Navigation in ``ppaas robot``: sends a robot to a pose, stops it, shows its pose and goals, and moves its clone."""

import argparse
from typing import TYPE_CHECKING, Any

from ppaas.errors import PPaaSError, Unavailable
from robots.cli.output import show
from robots.cli.session import add_session_arguments, logged_in
from robots.cli.tasks.places import places_of
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

GOAL_COLUMNS = ("id", "pose", "state", "text")
MOVE_COLUMNS = ("id", "map", "initial_pose")
STATE_COLUMNS = ("connected", "disconnected_since", "container", "pose", "localization", "goals")
POLL = 0.5
"""Interval of queries while a command waits for the end of a goal [s]."""

ACTIVE = ("pending", "active")


def configure_go(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``ppaas robot go``."""
    parser.add_argument("id")
    parser.add_argument(
        "place", nargs="+", help="x, y [m] and, optionally, yaw [rad] in the frame of the map, or the name of a station"
    )
    parser.add_argument("--wait", action="store_true", help="wait for the end of the goal; exit with 1 unless reached")
    add_session_arguments(parser)


def configure_state(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``ppaas robot state`` and ``ppaas robot stop``."""
    parser.add_argument("id")
    add_session_arguments(parser)


def configure_move(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``ppaas robot move``."""
    parser.add_argument("id", help="id of the robot; OWNER:ID for one of another user")
    parser.add_argument("--map", required=True, help="map that it is on now")
    parser.add_argument(
        "--at", type=float, nargs=3, required=True, metavar=("X", "Y", "YAW"), help="pose on that map [m, m, rad]"
    )
    add_session_arguments(parser)


async def move(arguments: argparse.Namespace) -> None:
    """Report that a robot is on another map now."""
    path = path_of("robots", arguments.id, "move")
    moved = await logged_in(arguments).post(path, {"map": arguments.map, "pose": arguments.at})
    show(moved, MOVE_COLUMNS, as_json=arguments.json)


async def go(arguments: argparse.Namespace) -> None:
    """Send a robot to a pose.

    Raises
    ------
    PPaaSError
        With ``--wait``, the goal was not reached; the text has the reason.
    """
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads this module

    client, path = logged_in(arguments), path_of("robots", arguments.id, "goals")
    goal = await client.post(path, {"pose": await _pose(client, arguments)})
    while arguments.wait and goal["state"] in ACTIVE:
        await asyncio.sleep(POLL)
        goal = await client.get(path_of("robots", arguments.id, "goals", goal["id"]))
    show(goal, GOAL_COLUMNS, as_json=arguments.json)
    if arguments.wait and goal["state"] != "succeeded":
        raise _not_reached(goal)


async def _pose(client: "RestClient", arguments: argparse.Namespace) -> list[float]:
    try:
        return [float(word) for word in arguments.place]
    except ValueError:  # a name: the map is known to the cloud
        robot = await client.get(path_of("robots", arguments.id))
        [place] = await places_of(client, robot["map"], [arguments.place])
        return place


def _not_reached(goal: dict[str, Any]) -> PPaaSError:
    return Unavailable(f"the goal was not reached: {goal['state']}: {goal['text'] or 'no reason was given'}")


async def state(arguments: argparse.Namespace) -> None:
    """Show the pose and the goals of a robot."""
    found = await logged_in(arguments).get(path_of("robots", arguments.id, "state"))
    if not arguments.json:
        found["goals"] = ", ".join(goal["id"] for goal in found["goals"] or ())
    show(found, STATE_COLUMNS, as_json=arguments.json)


async def stop(arguments: argparse.Namespace) -> None:
    """Cancel all goals of a robot."""
    await logged_in(arguments).delete(path_of("robots", arguments.id, "goals"))
