"""Command ``ppaas bridge agv``: takes AGVs of other makers, with VDA 5050, as robots of the account."""

import argparse

from robots.bridges.cli.vda5050 import add_broker_arguments, broker_of, run_logged
from robots.cli.session import add_cloud_arguments, token_of

HELP = "take AGVs with VDA 5050 as robots, which the cloud leads along paths, over MQTT"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_cloud_arguments(parser)
    add_broker_arguments(parser)
    parser.add_argument(
        "--agv",
        action="append",
        type=_agv,
        default=[],
        metavar="MANUFACTURER/SERIAL=ROBOT",
        help="take this AGV, as this robot; may be repeated (all AGVs of the broker, by serial number)",
    )
    parser.add_argument(
        "--map",
        action="append",
        type=_pair,
        default=[],
        metavar="AGV_MAP=MAP",
        help="the AGVs' name of a map of the cloud; may be repeated (the same name)",
    )
    parser.add_argument("--no-register", action="store_true", help="take registered robots only")
    parser.add_argument("--radius", type=_length, metavar="M", help="radius of AGVs without a factsheet")
    parser.add_argument(
        "--base", type=_length, default=10.0, metavar="M", help="length of the route that is released (%(default)g m)"
    )
    parser.add_argument(
        "--deviation",
        type=_length,
        default=0.3,
        metavar="M",
        help="distance at which a node on the way counts as reached (%(default)g m)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Lead AGVs until interrupted; return the exit status."""
    return run_logged(_run(arguments))


async def _run(arguments: argparse.Namespace) -> None:
    # Imported here because ``ppaas --help`` loads this module.
    from ppaas.wire.vda5050.master.settings import Settings  # noqa: PLC0415
    from robots.bridges.agv.fleet import Fleet  # noqa: PLC0415
    from robots.bridges.agv.options import FleetOptions  # noqa: PLC0415

    broker = broker_of(arguments)
    options = FleetOptions(
        robots=dict(arguments.agv),
        maps=dict(arguments.map),
        interface=arguments.interface,
        register=not arguments.no_register,
        radius=arguments.radius,
        settings=Settings(base_length=arguments.base, deviation=arguments.deviation),
    )
    await Fleet(arguments.url, token_of(arguments), broker, options).run()


def _agv(text: str) -> tuple[str, str]:
    agv, robot = _pair(text)
    if agv.count("/") != 1:
        raise argparse.ArgumentTypeError(f"name the AGV as MANUFACTURER/SERIAL, not {agv!r}")
    return agv, robot


def _pair(text: str) -> tuple[str, str]:
    name, _, other = text.rpartition("=")
    if not (name and other):
        raise argparse.ArgumentTypeError(f"name both, as A=B, not {text!r}")
    return name, other


def _length(text: str) -> float:
    value = float(text)
    if not 0.0 < value <= 1000.0:
        raise argparse.ArgumentTypeError(f"must be above 0 and at most 1000 m, not {text}")
    return value
