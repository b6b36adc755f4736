"""What was found out at some cost, noted on the disk for as long as what it was made from stays the same."""

import contextlib
import fcntl
import hashlib
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import msgspec


def notes_folder() -> Path:
    """Return the folder in which all that is found out is kept."""
    return Path(os.environ.get("NUMBA_CACHE_DIR") or Path("~/.cache/ppaas").expanduser())


def note_file(kind: str, made_from: Iterable[str]) -> Path:
    """Return where the note of a kind lies that is made from so much."""
    return notes_folder() / f"{kind}-{hashlib.sha256(chr(10).join(made_from).encode()).hexdigest()[:32]}.json"


def source_of(file: Path) -> str:
    """Return what tells of a file whether it is still the same."""
    return f"{file} {file.stat().st_mtime_ns} {file.stat().st_size}"


def write_note(file: Path, told: Any) -> None:
    """Write a note, whole or not at all; ``OSError`` where it cannot be kept."""
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_suffix(f".{os.getpid()}")
    partial.write_bytes(msgspec.json.encode(told))
    partial.replace(file)


@contextlib.contextmanager
def alone(file: Path) -> Iterator[None]:
    """Wait until no other process is in here by the same file: each would do the same work.

    Where no file can be kept nobody waits, and nothing that is found out is kept either.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        lock = file.open("w")
    except OSError:
        yield
        return
    with lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
