"""The port of a disk: the little that ``storage.files.map_log`` asks of it, be it here, in memory or a whole cluster.

Paths are names with slashes between, beneath the folder that a disk begins at.
"""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Protocol


class Disk(Protocol):
    """Files that appear whole or not at all, and are never changed."""

    def folders(self) -> list[str]:
        """Return the names of the folders at the top."""
        ...

    def names(self, folder: str) -> list[str]:
        """Return what is in a folder; nothing if there is none."""
        ...

    def read(self, path: str) -> bytes:
        """Return a small file; ``FileNotFoundError`` if there is none."""
        ...

    def create(self, path: str, data: bytes) -> bool:
        """Keep a small file, for good when this returns; tell whether it is new: one that is there stays as it is."""
        ...

    def place(self, source: Path, path: str) -> None:
        """Keep a copy of a local file, for good when this returns; one that is there has the same in it."""
        ...

    def opened(self, path: str) -> AbstractContextManager[Path]:
        """Give a file a path on this machine for a while; ``FileNotFoundError`` if there is none."""
        ...

    def remove(self, path: str) -> None:
        """Forget a file, or a folder with all that is in it, if there is one."""
        ...

    def drafting(self) -> AbstractContextManager[Path]:
        """Make a folder on this machine, best where files are placed from; it goes with the block, or its process."""
        ...
