"""Command ``ppaas bridge rmf [ROBOT …]``: presents robots as a fleet to Open-RMF."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.errors import InvalidInput
from robots.bridges.cli.ros2 import add_transport_arguments, transport_of
from robots.bridges.cli.vda5050 import run_logged
from robots.cli.session import add_cloud_arguments, rest_client, token_of

if TYPE_CHECKING:
    from ppaas.wire.rmf.level_frame import LevelFrame

HELP = "present robots as a fleet to Open-RMF, which sends them along the lanes of its graph"

WORST = 0.5
"""Residual from which reference points are refused [m]: one of them is wrong."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_robots_arguments(parser)
    parser.add_argument("--fleet", required=True, metavar="NAME", help="name of the fleet in Open-RMF")
    parser.add_argument(
        "--level",
        action="append",
        type=named_pair,
        default=[],
        metavar="MAP=LEVEL",
        help="name of the level of a map of the cloud; may be repeated (the id of the map)",
    )
    parser.add_argument(
        "--transform",
        type=Path,
        metavar="FILE",
        help="YAML with 'reference_coordinates' of each level: points in 'rmf' and the same ones in 'robot', as "
        "configurations of fleet adapters have them (both frames are the same)",
    )
    parser.add_argument(
        "--period", type=_period, default=0.5, metavar="S", help="time between two states (%(default)g s)"
    )
    add_transport_arguments(parser)


def add_robots_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the robots, their names in Open-RMF, and the options of the cloud."""
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help="ids of the robots (all of the user)")
    add_cloud_arguments(parser)
    parser.add_argument(
        "--name",
        action="append",
        type=named_pair,
        default=[],
        metavar="ROBOT=NAME",
        help="name of a robot in Open-RMF; may be repeated (its id)",
    )


async def robots_of(arguments: argparse.Namespace) -> list[str]:
    """Return the ids of the robots of the arguments, by default of all robots of the user."""
    named: list[str] = arguments.robots
    rest = rest_client(arguments.url, token_of(arguments))
    return named or [one["id"] for one in await rest.items("/v1/robots")]


def run(arguments: argparse.Namespace) -> int:
    """Present the fleet until interrupted; return the exit status."""
    return run_logged(_run(arguments))


async def _run(arguments: argparse.Namespace) -> None:
    # Imported here because ``ppaas --help`` loads this module.
    from robots.bridges.rmf.fleet import present  # noqa: PLC0415
    from robots.bridges.rmf.options import FleetForRmf  # noqa: PLC0415

    token = token_of(arguments)
    frames = {} if arguments.transform is None else _frames(arguments.transform)
    robots = await robots_of(arguments)
    names, levels = dict(arguments.name), dict(arguments.level)
    options = FleetForRmf(arguments.fleet, names, levels, frames, arguments.period)
    await present(transport_of(arguments), arguments.url, token, robots, options)


def _frames(file: Path) -> "dict[str, LevelFrame]":
    import logging  # noqa: PLC0415 - ``ppaas --help`` loads this module

    from robots.bridges.rmf.options import read_frames  # noqa: PLC0415

    try:
        frames = read_frames(file.read_bytes())
    except OSError as error:
        raise InvalidInput(f"the reference points cannot be read: {error}") from error
    for level, found in frames.items():
        turned = f"turned by {found.rotation:.4f} rad"
        fit = f"level {level}: scale {found.scale:.4f}, {turned}, residual {found.residual:.3f} m"
        if found.residual > WORST:
            raise InvalidInput(f"{fit}: more than {WORST:g} m, so a pair of reference points is wrong")
        logging.getLogger(__name__).info("%s", fit)
    return frames


def named_pair(text: str) -> tuple[str, str]:
    """Return both names of a text such as ``tb1=cart``, for ``argparse``; ``ArgumentTypeError`` if one is missing."""
    one, _, other = text.partition("=")
    if not (one and other):
        raise argparse.ArgumentTypeError(f"name both, as A=B, not {text!r}")
    return one, other


def _period(text: str) -> float:
    value = float(text)
    if not 0.1 <= value <= 10.0:
        raise argparse.ArgumentTypeError(f"must be 0.1 to 10 s, not {text}")
    return value
