"""Command ``ppaas bridge ros2 ROBOT``: connects a robot with ROS 2 to its clone."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from robots.bridges.cli.running import run_bridge
from robots.cli.session import add_cloud_arguments

if TYPE_CHECKING:
    from robots.bridges.core.transport import Transport

HELP = "connect a robot with ROS 2 to the cloud; no ROS is needed where the bridge runs"

TRANSPORTS = ("dds", "zenoh", "rclpy")
RELEASES = ("humble", "jazzy", "kilted", "lyrical")
"""The same as `ppaas.wire.ros.graph.ROS_2_RELEASES`, whose module is not loaded for a help text."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("robot", metavar="ROBOT", help="id of the robot, as registered by 'ppaas robot put'")
    add_cloud_arguments(parser)
    parser.add_argument("--namespace", help="namespace of the robot's nodes (found by its odometry and scans)")
    add_transport_arguments(parser)


def add_transport_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the transport, and of the graph of ROS 2."""
    parser.add_argument(
        "--transport",
        choices=TRANSPORTS,
        default=TRANSPORTS[0],
        help="how the robot's nodes communicate: dds, the default of ROS 2; zenoh for rmw_zenoh; "
        "rclpy, where ROS 2 is installed (%(default)s)",
    )
    parser.add_argument(
        "--domain",
        type=_domain,
        default=os.environ.get("ROS_DOMAIN_ID", "0"),
        help="domain of the robot's nodes (ROS_DOMAIN_ID, else 0)",
    )
    parser.add_argument("--distro", choices=RELEASES, help="release of the robot's ROS 2 (found by the robot's nodes)")
    add_zenoh_arguments(parser, "transport zenoh")
    dds = parser.add_argument_group("transport dds")
    dds.add_argument(
        "--dds-config", type=Path, metavar="FILE", help="configuration of Cyclone DDS (XML; CYCLONEDDS_URI)"
    )


def add_zenoh_arguments(parser: argparse.ArgumentParser, title: str) -> None:
    """Add the options of a Zenoh session, as a group with a title."""
    zenoh = parser.add_argument_group(title)
    zenoh.add_argument(
        "--listen",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help="be the router to which robots connect, as tcp/0.0.0.0:7447; may be repeated",
    )
    zenoh.add_argument(
        "--connect",
        action="append",
        default=[],
        metavar="ENDPOINT",
        help="connect to a router, as tcp/robot:7447 (that of this computer, if it has one); may be repeated",
    )
    zenoh.add_argument("--zenoh-config", type=Path, metavar="FILE", help="configuration of Zenoh (JSON5), as for TLS")


def run(arguments: argparse.Namespace) -> int:
    """Carry messages until interrupted; return the exit status."""
    return run_bridge(arguments, lambda: (transport_of(arguments), {}))


def transport_of(arguments: argparse.Namespace) -> "Transport":
    """Return the transport of the options; raises ``InvalidInput`` if a package that it needs is not installed."""
    release = arguments.distro or ""
    if arguments.transport == "dds":
        from robots.bridges.dds.node import DdsOptions, DdsTransport  # noqa: PLC0415

        return DdsTransport(DdsOptions(arguments.domain, release, arguments.dds_config))
    if arguments.transport == "rclpy":
        from robots.bridges.rclpy.node import RclpyOptions, RclpyTransport  # noqa: PLC0415

        return RclpyTransport(RclpyOptions(arguments.domain, release))
    from robots.bridges.zenoh.node import ZenohOptions, ZenohTransport  # noqa: PLC0415

    listen, connect = tuple(arguments.listen), tuple(arguments.connect)
    return ZenohTransport(ZenohOptions(listen, connect, arguments.zenoh_config, arguments.domain, release))


def _domain(text: str) -> int:
    domain = int(text)
    if not 0 <= domain <= 232:
        raise argparse.ArgumentTypeError(f"a domain is a number from 0 to 232, not {domain}")
    return domain
