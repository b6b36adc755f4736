"""``ppaas machine ticket``: print a ticket with which a machine of another host joins the cloud of a data folder."""

import argparse
import json
import math
import sys
import time
from pathlib import Path

HELP = "print a single-use ticket for a machine of another host; run it on the host of the cloud's data folder"

MAX_VALIDITY = 7 * 24 * 3600.0
"""Longest validity of a ticket [s]."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--data", type=Path, default=Path("var"), help="data folder of the cloud (./%(default)s)")
    named = parser.add_mutually_exclusive_group()
    named.add_argument("--name", help="name of the machine, new or joined before (default: any new name)")
    named.add_argument(
        "--standby",
        metavar="NAME",
        help="make a ticket for 'ppaas up --standby' on the host of this name instead: with it, that host gets the key "
        "of the cloud's certificate authority",
    )
    parser.add_argument(
        "--host", help="name or address of this host for the machine (default: the address on which the cloud listens)"
    )
    parser.add_argument(
        "--valid", type=_seconds, default=600.0, metavar="SECONDS", help="validity of the ticket (%(default)s)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON with the ticket and its time of expiry")


def run(arguments: argparse.Namespace) -> int:
    """Print the ticket."""
    from endpoints.audit.event import AuditEvent  # noqa: PLC0415
    from endpoints.audit.file_log import record_on_host  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from engine.remote.authority import STANDBY  # noqa: PLC0415
    from engine.remote.machines import make_ticket  # noqa: PLC0415
    from engine.remote.replica import MACHINES  # noqa: PLC0415

    folder = arguments.data / MACHINES
    name = arguments.name if arguments.standby is None else f"{arguments.standby}{STANDBY}"
    expires = time.time() + arguments.valid
    ticket = make_ticket(folder, valid=arguments.valid, machine=name, host=arguments.host)
    details = {"valid": arguments.valid}
    record_on_host(arguments.data, AuditEvent(action="make_ticket", object=_machine(name), details=details))
    printed = json.dumps({"ticket": str(ticket), "expires": expires}) if arguments.json else str(ticket)
    sys.stdout.write(f"{printed}\n")
    return 0


def _machine(name: str | None) -> str:
    return "machines" if name is None else f"machines/{name}"


def _seconds(text: str) -> float:
    seconds = float(text)
    if not (math.isfinite(seconds) and 1.0 <= seconds <= MAX_VALIDITY):
        raise argparse.ArgumentTypeError(f"the validity must be 1 to {MAX_VALIDITY:.0f} s, not {text}")
    return seconds
