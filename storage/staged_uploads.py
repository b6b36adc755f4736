"""Files of a map on their way into a store: on a disk, hashed as they are written, and seen by nobody."""

import mmap
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import BinaryIO

from ppaas.errors import InvalidInput
from storage.disk_errors import disk_errors
from storage.hashing import HashBeside
from storage.records import MapFile
from storage.versions import PARTS, map_version

Buffer = bytes | mmap.mmap
"""What is in a file, read as it is asked for."""

BLOCK = 1 << 17
"""Bytes that are read or written at a time: they stay in the cache of a core until they are hashed and written."""


_BEGIN_EARLY = 8 << 20
"""Bytes after which the disk is told to begin with them, so that little is left to wait for at the end."""


class DraftFile:
    """A file that is being written.

    Parameters
    ----------
    file : BinaryIO
        Open, without a buffer.
    hashed : HashBeside
        Gets what is written.
    """

    def __init__(self, file: BinaryIO, hashed: HashBeside) -> None:
        self._file = file
        self._hashed = hashed
        self._size = 0
        self._begun = 0

    def write(self, data: bytes | memoryview) -> None:
        """Add bytes, which must not change until the file has ended."""
        self._hashed.add(data)
        left = memoryview(data)
        while left:  # of what has no room some is written, and no error is told until the next try
            left = left[self._file.write(left) :]
        self._size += len(data)
        if self._size - self._begun >= _BEGIN_EARLY:
            self._begin()

    def _begin(self) -> None:
        """Have the system write to the disk what has come; it goes on at once."""
        # This is what Linux does first when told that they are not needed; pages on their way to the disk are kept.
        os.posix_fadvise(self._file.fileno(), self._begun, self._size - self._begun, os.POSIX_FADV_DONTNEED)
        self._begun = self._size

    def end(self) -> MapFile:
        """Bring it to the disk; return what it is."""
        self._file.flush()
        os.fsync(self._file.fileno())
        return MapFile(self._hashed.end(), self._size)


class MapDraft:
    """What is to become a version of a map.

    Parameters
    ----------
    folder : Path
        Of its own.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.files: dict[str, MapFile] = {}

    @property
    def version(self) -> str:
        """The hash of its files."""
        return map_version(self.files)

    def path(self, part: str) -> Path:
        """Return where a file is."""
        return self._folder / part

    @contextmanager
    def writing(self, part: str) -> Iterator[DraftFile]:
        """Write a file, which counts once the block has ended well.

        Raises
        ------
        InvalidInput
            A map has no such file, or the draft has it already.
        Unavailable
            The disk is full, or the like.
        """
        if part not in PARTS or part in self.files:
            raise InvalidInput(f"a map has one each of {', '.join(PARTS)}, not {part!r} (again)")
        with (
            disk_errors(self.path(part)),
            self.path(part).open("wb", buffering=0) as file,
            closing(HashBeside()) as sha,
        ):
            draft = DraftFile(file, sha)
            yield draft
            self.files[part] = draft.end()

    def add(self, part: str, data: Iterable[bytes | memoryview]) -> None:
        """Write a whole file, block by block."""
        with self.writing(part) as file:
            for block in data:
                file.write(block)

    def buffer(self, part: str) -> Buffer:
        """Return what is in a file that was written."""
        with disk_errors(self.path(part)):
            return mapped(self.path(part))


def mapped(path: Path) -> Buffer:
    """Return what is in a file, mapped into memory: it takes room in it only while it is looked at."""
    with path.open("rb") as file:
        if not os.fstat(file.fileno()).st_size:
            return b""
        return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)


def blocks(data: Buffer, size: int = BLOCK) -> Iterator[bytes]:
    """Return what is in a file, so many bytes at a time."""
    return (data[start : start + size] for start in range(0, len(data), size))


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Make a folder for as long as the block lasts, where this machine keeps what is temporary."""
    with disk_errors(Path(tempfile.gettempdir())):
        folder = tempfile.TemporaryDirectory(prefix="ppaas-map-")
    with folder as name:
        yield Path(name)
