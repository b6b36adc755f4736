"""Verb ``ppaas robot drive``: drives a robot by hand from a terminal, or by lines of JSON."""

import argparse
import sys

from ppaas.bounded import above_zero
from ppaas.errors import InvalidInput
from robots.cli.session import add_cloud_arguments, token_of


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    parser.description = (
        "Hold a key to drive: i, j, l and , as in teleop_twist_keyboard, w, a, s, d, or the arrow keys. A terminal "
        "reports no release of a key: the robot stops 0.2 s after the last repeat. The clone checks each command, and "
        "stops the robot before obstacles."
    )
    parser.add_argument("id", help="id of a connected robot; OWNER:ID for one of another user")
    parser.add_argument(
        "--speed", type=above_zero(1.0), default=0.5, metavar="PART", help="part of the fastest speeds (0.5)"
    )
    parser.add_argument("--take-over", action="store_true", help="become the driver in place of another")
    parser.add_argument(
        "--json",
        action="store_true",
        help='drive by lines of JSON from a pipe, {"linear": 0.2, "angular": 0.0, "seconds": 0.25}; print states so',
    )
    add_cloud_arguments(parser)


async def run(arguments: argparse.Namespace) -> None:
    """Execute the verb.

    Raises
    ------
    InvalidInput
        There is no terminal; or a line of JSON is not valid.
    Conflict
        Another user drives, or has taken over; or the turn has lapsed.
    Unavailable
        The robot is not driven by hand, or does not answer.
    """
    if not arguments.json and not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise InvalidInput("driving by keys needs a terminal; programs drive by lines of JSON with --json")
    # ``ppaas --help`` loads this module, and must not load sockets.
    from robots.cli.driving.keyboard import drive_by_keys  # noqa: PLC0415
    from robots.cli.driving.lines import drive_by_lines  # noqa: PLC0415
    from robots.client.robot_client import RobotClient  # noqa: PLC0415
    from robots.client.teleop import driving_by_hand  # noqa: PLC0415

    client = RobotClient(arguments.url, robot=arguments.id, token=token_of(arguments), role="operator", hold=False)
    async with client, driving_by_hand(client, take_over=arguments.take_over) as hand:
        if arguments.json:
            await drive_by_lines(hand)
        else:
            await drive_by_keys(hand, arguments.id, arguments.speed)
