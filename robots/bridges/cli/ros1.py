"""Command ``ppaas bridge ros1 ROBOT``: connects a robot with ROS 1 to its clone."""

import argparse
import os
from typing import TYPE_CHECKING, Any

from robots.bridges.cli.running import run_bridge
from robots.cli.session import add_cloud_arguments

if TYPE_CHECKING:
    from robots.bridges.core.transport import Transport

HELP = "connect a robot with ROS 1 to the cloud; no ROS is needed where the bridge runs"

DEFAULT_MASTER = "http://localhost:11311"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("robot", metavar="ROBOT", help="id of the robot, as registered by 'ppaas robot put'")
    add_cloud_arguments(parser)
    parser.add_argument(
        "--master",
        metavar="URI",
        default=os.environ.get("ROS_MASTER_URI") or DEFAULT_MASTER,
        help=f"URI of the robot's master (ROS_MASTER_URI, else {DEFAULT_MASTER})",
    )
    parser.add_argument(
        "--host",
        metavar="ADDRESS",
        default=os.environ.get("ROS_HOSTNAME") or os.environ.get("ROS_IP") or "",
        help="name or address of this computer that the robot reaches (ROS_HOSTNAME or ROS_IP, else the address by "
        "which this computer reaches the master)",
    )
    parser.add_argument("--namespace", help="namespace of the robot's nodes (found by its odometry and scans)")


def run(arguments: argparse.Namespace) -> int:
    """Carry messages until interrupted; return the exit status."""
    return run_bridge(arguments, lambda: _opened(arguments))


def _opened(arguments: argparse.Namespace) -> "tuple[Transport, dict[str, Any]]":
    # Imported here because ``ppaas --help`` loads this module.
    from robots.bridges.ros1.move_base import MoveBaseAction  # noqa: PLC0415
    from robots.bridges.ros1.node import Ros1Options, Ros1Transport, node_name  # noqa: PLC0415

    options = Ros1Options(arguments.master, arguments.host)
    return Ros1Transport(options, node_name(arguments.robot)), {"actions": MoveBaseAction}
