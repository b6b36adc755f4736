"""Command ``ppaas bridge free-fleet [ROBOT …]``: presents robots to free_fleet of Open-RMF."""

import argparse

from ppaas.errors import Conflict, InvalidInput
from robots.bridges.cli.rmf import add_robots_arguments, robots_of
from robots.bridges.cli.ros2 import RELEASES, add_zenoh_arguments
from robots.bridges.cli.vda5050 import run_logged
from robots.cli.session import token_of

HELP = "present robots to free_fleet, the fleet adapter of Open-RMF for robots with Navigation2, over Zenoh"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_robots_arguments(parser)
    parser.add_argument(
        "--robot-frame",
        default="base_footprint",
        metavar="FRAME",
        help="name of the robots' frame, as 'robot_frame' in the adapter's configuration (%(default)s)",
    )
    parser.add_argument("--distro", choices=RELEASES, default="jazzy", help="release of ROS 2 of RMF (%(default)s)")
    add_zenoh_arguments(parser, "Zenoh")


def run(arguments: argparse.Namespace) -> int:
    """Present the robots until interrupted; return the exit status."""
    return run_logged(_run(arguments))


async def _run(arguments: argparse.Namespace) -> None:
    # Imported here because ``ppaas --help`` loads this module.
    from robots.bridges.free_fleet.plain_zenoh import PlainZenohTransport  # noqa: PLC0415
    from robots.bridges.free_fleet.robot import present  # noqa: PLC0415
    from robots.bridges.zenoh.node import ZenohOptions  # noqa: PLC0415

    names = dict(arguments.name)
    robots = {robot: names.get(robot, robot) for robot in await robots_of(arguments)}
    if not robots:
        raise InvalidInput("the user has no robots to present: name some, as OWNER:ID for those of others")
    if len({*robots.values()}) < len(robots):
        raise Conflict("two robots would have one name: give one of them another by --name")
    options = ZenohOptions(
        tuple(arguments.listen), tuple(arguments.connect), arguments.zenoh_config, release=arguments.distro
    )
    await present(PlainZenohTransport(options), arguments.url, token_of(arguments), robots, arguments.robot_frame)
