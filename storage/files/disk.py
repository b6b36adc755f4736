"""Port of a disk: the file operations that ``storage.files.map_log`` needs, local, in memory or in HDFS.

Paths are relative to the root folder of the disk, with slashes between names. Files of a map are opened after their
hashes have been verified.
"""

import hashlib
from collections.abc import Collection
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import Protocol

from ppaas.errors import Unavailable
from storage.map_port import OpenMap
from storage.records import MapFile, MapRecord
from storage.staged_uploads import Buffer, mapped


class Disk(Protocol):
    """A disk of immutable files, each of which appears atomically."""

    def folders(self) -> list[str]:
        """Return the names of the top-level folders."""
        ...

    def names(self, folder: str) -> list[str]:
        """Return the names in a folder; an empty list if it does not exist."""
        ...

    def read(self, path: str) -> bytes:
        """Return the content of a small file; ``FileNotFoundError`` if it does not exist."""
        ...

    def create(self, path: str, data: bytes) -> bool:
        """Create a small file, durably; return whether it is new. An existing file is left unchanged."""
        ...

    def place(self, source: Path, path: str) -> None:
        """Store a copy of a local file, durably. An existing file has the same content."""
        ...

    def move(self, source: str, target: str) -> bool:
        """Rename a file within a folder; return False if it does not exist. An existing target is replaced."""
        ...

    def opened(self, path: str) -> AbstractContextManager[Path]:
        """Make a file available under a local path in the block; ``FileNotFoundError`` if it does not exist."""
        ...

    def remove(self, path: str) -> None:
        """Remove a file, or a folder with its content, if it exists."""
        ...

    def staging_folder(self) -> AbstractContextManager[Path]:
        """Create a local folder for files to ``place``; it is removed at the end of the block, or of the process."""
        ...


def open_verified(stack: ExitStack, disk: Disk, folder: str, record: MapRecord, only: Collection[str]) -> OpenMap:
    """Return a map with its files, open until the stack is closed; ``Unavailable`` if a file is damaged."""
    opened = OpenMap(record)
    for part, file in record.present.files.items():
        if part in only:
            path = opened.paths[part] = stack.enter_context(disk.opened(f"{folder}/{file.sha256}"))
            opened.buffers[part] = _verified(mapped(path), record, part, file)
    return opened


def _verified(data: Buffer, record: MapRecord, part: str, file: MapFile) -> Buffer:
    if len(data) != file.size or hashlib.sha256(data).hexdigest() != file.sha256:
        raise Unavailable(f"the {part} of map {record.id!r} is damaged (its hash differs): publish it again")
    return data
