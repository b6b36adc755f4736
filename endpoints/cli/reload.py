"""Reload of the settings of the cloud process of a data folder: signals it, and waits for its report."""

import os
import signal
import time
from pathlib import Path

import msgspec

from endpoints.settings.reload import REPORT, ReloadReport
from engine.processes.exclusive_owner import LOCK, owner_of
from ppaas.clock import uptime
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, Unavailable

TIMEOUT, LOOK = 30.0, 0.02
"""Time within which the process reports, and the period of looks [s]."""


def reload(data: Path) -> ReloadReport:
    """Have the cloud process of a data folder read its settings again; return its report.

    Raises
    ------
    Unavailable
        No process of this host uses the folder, it takes no reloads, or does not report in time.
    InvalidInput
        A setting is misspelt or wrong; the settings stay as they are.
    """
    owner = owner_of(data / LOCK)
    if owner is None:
        raise Unavailable(f"no cloud process of this host uses {data}: name its data folder by --data")
    if _report(data, owner.pid) is None:
        raise Unavailable(f"{owner} takes no reloads: it begins at this moment, or is of an earlier release")
    asked = uptime()
    os.kill(owner.pid, signal.SIGHUP)
    while (report := _report(data, owner.pid)) is None or report.began < asked:
        if uptime() - asked > TIMEOUT or owner_of(data / LOCK) != owner:
            raise Unavailable(f"{owner} has not reported within {TIMEOUT:g} s; see its log")
        time.sleep(LOOK)
    if report.problem:
        raise InvalidInput(f"the settings stay as they are: {report.problem}")
    return report


def _report(data: Path, pid: int) -> ReloadReport | None:
    try:
        report = from_json((data / REPORT).read_bytes(), ReloadReport)
    except (OSError, msgspec.DecodeError):
        return None
    return report if report.pid == pid else None
