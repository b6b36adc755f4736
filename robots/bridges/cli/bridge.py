"""Command ``ppaas bridge``: connects a robot that speaks another protocol than rosbridge."""

import argparse
from importlib.metadata import entry_points

from robots.cli.plugins import installed

NAME = "bridge"
HELP = "connect robots with ROS, rovers with MAVLink, AGVs or a master control of VDA 5050, and Open-RMF to the cloud"

BRIDGES = "ppaas.bridges"
"""Group of bridges: modules with HELP, configure(parser) and run(arguments)."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    bridges = parser.add_subparsers(dest="bridge", required=True, metavar="PROTOCOL")
    for name, module in installed(bridges, entry_points(group=BRIDGES), getattr(parser, "words", None) or ()):
        one = bridges.add_parser(name, help=module.HELP, description=module.HELP)
        module.configure(one)
        one.set_defaults(run_bridge=module.run)


def run(arguments: argparse.Namespace) -> int:
    """Run a bridge until interrupted; return the exit status."""
    status: int = arguments.run_bridge(arguments)
    return status
