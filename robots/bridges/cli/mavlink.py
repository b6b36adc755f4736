"""Command ``ppaas bridge mavlink``: connects a rover that speaks MAVLink to its clone."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING

from robots.bridges.cli.vda5050 import run_logged
from robots.cli.session import add_cloud_arguments, token_of

if TYPE_CHECKING:
    from robots.bridges.mavlink.bridge import BridgeOptions

HELP = "connect a rover of ArduPilot or PX4 to the cloud, by MAVLink"

STATION = 255
"""Usual number of a ground station, the one that ArduPilot's failsafe watches (SYSID_MYGCS)."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_cloud_arguments(parser)
    parser.add_argument(
        "--robot", required=True, metavar="ID", help="id of the robot, as registered by 'ppaas robot put'"
    )
    parser.add_argument(
        "--vehicle",
        required=True,
        metavar="ADDRESS",
        help="udpin:0.0.0.0:14550, udpout:HOST:PORT, tcp:HOST:PORT or /dev/ttyACM0[,BAUD]",
    )
    parser.add_argument("--system", type=_number, metavar="N", help="number of the vehicle (that of the only one)")
    parser.add_argument(
        "--station", type=_number, default=STATION, metavar="N", help="number of this ground station (%(default)s)"
    )
    parser.add_argument(
        "--anchor",
        type=_anchor,
        metavar="LATITUDE,LONGITUDE[,YAW]",
        help="where the map's origin is on the Earth, and the angle from east to its x axis [°] (as the map says)",
    )
    parser.add_argument("--arm", action="store_true", help="let the bridge arm the vehicle for a goal")
    parser.add_argument(
        "--signing-key-file",
        type=Path,
        metavar="FILE",
        help="sign messages, and take signed ones alone: 64 hexadecimal digits, or a passphrase, as of Mission Planner",
    )


def run(arguments: argparse.Namespace) -> int:
    """Carry messages until interrupted; return the exit status."""
    return run_logged(_run(arguments))


async def _run(arguments: argparse.Namespace) -> None:
    # Imported here because ``ppaas --help`` loads this module.
    from robots.bridges.mavlink.bridge import MavlinkBridge  # noqa: PLC0415

    token = token_of(arguments)
    await MavlinkBridge(arguments.url, token, arguments.robot, options_of(arguments)).run()


def options_of(arguments: argparse.Namespace) -> "BridgeOptions":
    """Return the options of a bridge.

    Raises
    ------
    InvalidInput
        The address is none, or the key cannot be read.
    InvalidMap
        The anchor is not on the Earth.
    """
    from ppaas.maps.georeference import GeoAnchor  # noqa: PLC0415 - as above
    from robots.bridges.mavlink.bridge import BridgeOptions  # noqa: PLC0415
    from robots.bridges.mavlink.dialect import check_installed  # noqa: PLC0415
    from robots.bridges.mavlink.link import VehicleAddress  # noqa: PLC0415
    from robots.bridges.mavlink.station import StationOptions, key_of  # noqa: PLC0415

    check_installed()
    key = None if arguments.signing_key_file is None else key_of(arguments.signing_key_file)
    station = StationOptions(VehicleAddress.parse(arguments.vehicle), arguments.system, arguments.station, key)
    anchor = None if arguments.anchor is None else GeoAnchor(*arguments.anchor)
    return BridgeOptions(station, anchor, arguments.arm)


def _number(text: str) -> int:
    number = int(text)
    if not 1 <= number <= 255:
        raise argparse.ArgumentTypeError(f"a number of MAVLink is from 1 to 255, not {text}")
    return number


def _anchor(text: str) -> tuple[float, float, float]:
    numbers = [float(part) for part in text.split(",")]
    if len(numbers) not in (2, 3):
        raise argparse.ArgumentTypeError(f"give latitude, longitude and the angle of the map, not {text!r}")
    return numbers[0], numbers[1], math.radians(numbers[2]) if len(numbers) == 3 else 0.0
