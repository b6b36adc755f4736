"""Notes on disk: cached results that are valid while their inputs stay unchanged."""

import contextlib
import fcntl
import hashlib
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import msgspec


def notes_folder() -> Path:
    """Return the folder of all notes."""
    return Path(os.environ.get("NUMBA_CACHE_DIR") or Path("~/.cache/ppaas").expanduser())


def note_file(kind: str, made_from: Iterable[str]) -> Path:
    """Return the path of a note of this kind for these inputs."""
    return notes_folder() / f"{kind}-{hashlib.sha256(chr(10).join(made_from).encode()).hexdigest()[:32]}.json"


def source_of(file: Path) -> str:
    """Return a text that changes when a file changes: its path, modification time and size."""
    return f"{file} {file.stat().st_mtime_ns} {file.stat().st_size}"


def write_note(file: Path, content: Any) -> None:
    """Write a note atomically; raises ``OSError`` if it cannot be written."""
    file.parent.mkdir(parents=True, exist_ok=True)
    partial = file.with_suffix(f".{os.getpid()}")
    partial.write_bytes(msgspec.json.encode(content))
    partial.replace(file)


@contextlib.contextmanager
def exclusive(file: Path) -> Iterator[None]:
    """Hold an exclusive lock on a file, so that only one process does the same work.

    Where the file cannot be created nothing is locked; notes cannot be written there either.
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
