"""``ppaas machine ticket``: let a machine of another host join the cloud of a data folder."""

import argparse
import math
import sys
from pathlib import Path

HELP = "print a ticket with which a machine of another host may join, once; beside the cloud's data folder"

LONGEST = 7 * 24 * 3600.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--data", type=Path, default=Path("var"), help="data folder of the cloud (./%(default)s)")
    parser.add_argument("--name", help="of the machine, which may have joined before (any that is new)")
    parser.add_argument("--host", help="by which it reaches this host (as the cloud listens)")
    parser.add_argument(
        "--valid", type=_seconds, default=600.0, metavar="SECONDS", help="how long the ticket is good (%(default)s)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print the ticket."""
    from endpoints.server import MACHINES  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from engine.remote.machines import make_ticket  # noqa: PLC0415

    folder = arguments.data / MACHINES
    ticket = make_ticket(folder, valid=arguments.valid, machine=arguments.name, host=arguments.host)
    sys.stdout.write(f"{ticket}\n")
    return 0


def _seconds(text: str) -> float:
    seconds = float(text)
    if not (math.isfinite(seconds) and 1.0 <= seconds <= LONGEST):
        raise argparse.ArgumentTypeError(f"a ticket is good for 1 to {LONGEST:.0f} s, not {text}")
    return seconds
