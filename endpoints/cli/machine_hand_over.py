"""``ppaas machine hand-over``: let a standby lead in place of the cloud process of a data folder, which ends."""

import argparse
import json
import os
import signal
import sys
import time
from pathlib import Path

from ppaas.errors import Unavailable

HELP = "let a standby lead in place of the cloud process of a data folder, which ends; run it on the host of the folder"

TIMEOUT, LOOK = 20.0, 0.1
"""Time within which the process ends, and the period at which it is looked for [s]."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--data", type=Path, default=Path("var"), help="data folder of the process (./%(default)s)")
    parser.add_argument("--json", action="store_true", help="print JSON with the process, and the time that it took")


def run(arguments: argparse.Namespace) -> int:
    """Hand over, and wait until the process has ended.

    Raises
    ------
    Unavailable
        No process of this host uses the data folder, or it did not end: it does not lead.
    """
    from endpoints.audit.event import AuditEvent  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from endpoints.audit.file_log import record_on_host  # noqa: PLC0415
    from engine.processes.exclusive_owner import LOCK, owner_of  # noqa: PLC0415

    owner, began = owner_of(arguments.data / LOCK), time.monotonic()
    if owner is None:
        raise Unavailable(f"no cloud process of this host uses {arguments.data}: name its data folder by --data")
    record_on_host(arguments.data, AuditEvent(action="hand_over", object=f"processes/{owner.pid}"))
    os.kill(owner.pid, signal.SIGUSR1)
    while owner_of(arguments.data / LOCK) == owner:
        if time.monotonic() - began > TIMEOUT:
            raise Unavailable(f"{owner} still runs after {TIMEOUT:g} s: it does not lead, or is stopped; see its log")
        time.sleep(LOOK)
    took = time.monotonic() - began
    told = (
        json.dumps({"pid": owner.pid, "seconds": took}) if arguments.json else f"{owner} has ended after {took:.1f} s"
    )
    sys.stdout.write(f"{told}\n")
    return 0
