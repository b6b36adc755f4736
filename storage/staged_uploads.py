"""Staged uploads: files of a map that are written to disk and hashed, but not published yet."""

import hashlib
import mmap
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, contextmanager
from pathlib import Path
from typing import BinaryIO

from ppaas.errors import InvalidInput
from storage.records import MapFile
from storage.store_errors import disk_errors
from storage.versions import PARTS, files_after

Buffer = bytes | mmap.mmap
"""Content of a file; a memory map reads it on access."""

BLOCK = 1 << 17
"""Block size of reads and writes [bytes]: a block stays in the cache of a core until it is hashed and written."""

_WRITEBACK_BYTES = 8 << 20
"""Bytes after which writeback to the disk is started, so that the final fsync has little left to do."""

AT_ONCE = 1 << 20
"""Bytes that are handed to the thread at once; the handover costs as much as hashing ten thousand bytes."""

Block = bytes | memoryview


class BackgroundHash:
    """SHA-256 of blocks, in a second thread: hashing takes about as long as writing.

    Short data and the last blocks are hashed by the caller.
    """

    def __init__(self) -> None:
        self._digest = hashlib.sha256()
        self._blocks: list[Block] = []
        self._size = 0
        self._threads = ThreadPoolExecutor(1, "hash")  # starts its thread with the first submit
        self._hashing: Future[None] | None = None

    def add(self, data: Block) -> None:
        """Add a block, which must not change before ``end``: it may be hashed as late as that."""
        self._blocks.append(data)
        self._size += len(data)
        if self._size >= AT_ONCE:
            self._wait_for_thread()  # at most twice `AT_ONCE` waits in memory
            self._hashing = self._threads.submit(self._hash, self._blocks)
            self._blocks, self._size = [], 0

    def end(self) -> str:
        """Return the SHA-256 of all blocks, in hex."""
        self._wait_for_thread()
        self._hash(self._blocks)
        return self._digest.hexdigest()

    def close(self) -> None:
        """Stop the thread."""
        self._threads.shutdown()

    def _wait_for_thread(self) -> None:
        if self._hashing is not None:
            self._hashing.result()

    def _hash(self, blocks: Sequence[Block]) -> None:
        for block in blocks:
            self._digest.update(block)


class StagedFile:
    """A file that is being written.

    Parameters
    ----------
    file : BinaryIO
        Open for writing, unbuffered.
    hashed : BackgroundHash
        Hashes the written data.
    """

    def __init__(self, file: BinaryIO, hashed: BackgroundHash) -> None:
        self._file = file
        self._hashed = hashed
        self._size = 0
        self._flushed = 0

    def write(self, data: bytes | memoryview) -> None:
        """Append data, which must not change before ``end``."""
        self._hashed.add(data)
        left = memoryview(data)
        while left:  # on a full disk a write is short, and only the next one raises
            left = left[self._file.write(left) :]
        self._size += len(data)
        if self._size - self._flushed >= _WRITEBACK_BYTES:
            self._start_writeback()

    def _start_writeback(self) -> None:
        """Start writeback of the data so far; return at once."""
        # POSIX_FADV_DONTNEED first starts writeback on Linux; pages under writeback stay in the page cache.
        os.posix_fadvise(self._file.fileno(), self._flushed, self._size - self._flushed, os.POSIX_FADV_DONTNEED)
        self._flushed = self._size

    def end(self) -> MapFile:
        """Sync the file to the disk; return its hash and size."""
        self._file.flush()
        os.fsync(self._file.fileno())
        return MapFile(self._hashed.end(), self._size)


class StagedUpload:
    """The files of a map version before it is published.

    Parameters
    ----------
    folder : Path
        Folder that belongs to this upload alone.

    Attributes
    ----------
    files : dict of str to MapFile
        The files so far.
    keeps : frozenset of str
        Parts that a version made of it has from the current version of the map, unless they are among the files. They
        are none at first. If they are more than the zones, the map must exist.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.files: dict[str, MapFile] = {}
        self.keeps: frozenset[str] = frozenset()

    def files_after(self, current: Mapping[str, MapFile]) -> dict[str, MapFile]:
        """Return the files of a version made of it, given the files of the current version."""
        return files_after(self.files, self.keeps, current)

    def path(self, part: str) -> Path:
        """Return the path of a file."""
        return self._folder / part

    @contextmanager
    def writing(self, part: str) -> Iterator[StagedFile]:
        """Write a file in the ``with`` block; it is part of the upload if the block ends without an error.

        Raises
        ------
        InvalidInput
            A map has no such file, or the upload has it already.
        Unavailable
            The disk is full, or fails otherwise.
        """
        if part not in PARTS or part in self.files:
            raise InvalidInput(f"unknown or repeated file {part!r}: a map has at most one each of {', '.join(PARTS)}")
        with (
            disk_errors(self.path(part)),
            self.path(part).open("wb", buffering=0) as file,
            closing(BackgroundHash()) as sha,
        ):
            staged = StagedFile(file, sha)
            yield staged
            self.files[part] = staged.end()

    def add(self, part: str, data: Iterable[bytes | memoryview]) -> None:
        """Write a whole file, block by block."""
        with self.writing(part) as file:
            for block in data:
                file.write(block)

    def buffer(self, part: str) -> Buffer:
        """Return the content of a file of the upload."""
        with disk_errors(self.path(part)):
            return mapped(self.path(part))


def mapped(path: Path) -> Buffer:
    """Return the content of a file as a memory map, which is paged in only where it is read."""
    with path.open("rb") as file:
        if not os.fstat(file.fileno()).st_size:
            return b""
        return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)


def blocks(data: Buffer, size: int = BLOCK) -> Iterator[bytes]:
    """Yield the content of a file in blocks of ``size`` bytes."""
    return (data[start : start + size] for start in range(0, len(data), size))
