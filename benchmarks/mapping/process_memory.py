"""Memory of this process, from ``/proc`` of Linux."""

import re
from pathlib import Path

_PROC = Path("/proc/self")


def resident() -> float:
    """Return the resident memory [MiB]."""
    return _status("VmRSS")


def peak() -> float:
    """Return the largest resident memory since the last `forget_peak` [MiB]."""
    return _status("VmHWM")


def of_files() -> float:
    """Return the part of the resident memory that shows files, such as the code of libraries [MiB]."""
    return _status("RssFile")


def forget_peak() -> None:
    """Let the peak begin at the present memory."""
    (_PROC / "clear_refs").write_text("5")


def _status(name: str) -> float:
    found = re.search(rf"^{name}:\s+(\d+) kB", (_PROC / "status").read_text(), re.MULTILINE)
    assert found is not None
    return int(found[1]) / 1024.0
