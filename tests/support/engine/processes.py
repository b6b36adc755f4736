"""Queries of processes for tests."""

from pathlib import Path

import psutil

SOON = 5.0
"""Time limit for events that must happen soon [s]; generous, since machines that run tests are busy."""


def state(pid: int) -> str | None:
    """Return the state letter of a process, or None if there is none."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return None


def is_gone(pid: int) -> bool:
    """Return whether a process does not exist, not even as a zombie."""
    return state(pid) is None


def has_ended(pid: int) -> bool:
    """Return whether a process has exited; it may still be a zombie."""
    return state(pid) in (None, "Z", "X")


def memory(pid: int) -> int:
    """Return the resident memory of a process [bytes]."""
    return int(psutil.Process(pid).memory_info().rss)


def zombies() -> list[int]:
    """Return the zombies among the descendants of this process."""
    return [child.pid for child in psutil.Process().children(recursive=True) if state(child.pid) == "Z"]
