"""What tests ask about processes."""

from pathlib import Path

import psutil

SOON = 5.0
"""Seconds within which what must happen has to: generous, since machines that run tests are busy."""


def state(pid: int) -> str | None:
    """Return the state letter of a process, or None if there is none."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return None


def is_gone(pid: int) -> bool:
    """There is no such process, not even a zombie."""
    return state(pid) is None


def has_ended(pid: int) -> bool:
    """It runs no more, though whoever has to may not have taken note of it yet."""
    return state(pid) in (None, "Z", "X")


def memory(pid: int) -> int:
    """Return the resident memory of a process [bytes]."""
    return int(psutil.Process(pid).memory_info().rss)


def zombies() -> list[int]:
    """Return the zombies among the descendants of this process."""
    return [child.pid for child in psutil.Process().children(recursive=True) if state(child.pid) == "Z"]
