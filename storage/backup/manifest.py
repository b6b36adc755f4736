"""Manifests: what a backup contains, and in which blocks."""

import secrets
from datetime import UTC, datetime
from typing import TypeAlias

import msgspec

from ppaas import __version__

FORMAT, FORMAT_OF_RECORDS = 2, 1
"""Version of the format that this release writes for backups with files, and with records and maps alone.

It reads these and earlier ones. A release that knows no files refuses backups with them, instead of losing them.
"""


class Block(msgspec.Struct, frozen=True):
    """A block of records."""

    name: str
    records: int


class BackupStream(msgspec.Struct, frozen=True):
    """All records of a kind, in the order in which they are restored.

    ``index`` is the name of a block that lists what each of ``blocks`` has, where a later backup reuses them; empty if
    there is none.
    """

    blocks: tuple[Block, ...] = ()
    index: str = ""

    @property
    def records(self) -> int:
        """Number of records."""
        return sum(block.records for block in self.blocks)


class CloneLog(msgspec.Struct, frozen=True):
    """A log of a clone, whose entries are in blocks in the order of their numbers."""

    user: str
    robot: str
    log: str
    blocks: tuple[Block, ...]


class StoredPart(msgspec.Struct, frozen=True):
    """A file of a map version: its SHA-256 and size [bytes], and the blocks of which it consists."""

    sha256: str
    size: int
    blocks: tuple[str, ...]


class StoredFile(msgspec.Struct, frozen=True):
    """A file of a data folder.

    Parameters
    ----------
    name : str
        Path in the data folder.
    sha256 : str
    size : int
        [bytes]
    changed : float
        Time of its last write [s since the epoch].
    blocks : tuple of str
    """

    name: str
    sha256: str
    size: int
    changed: float
    blocks: tuple[str, ...]


Versions: TypeAlias = dict[str, dict[str, StoredPart]]
"""Map versions by their hash; of each the files by part."""


class BackupManifest(msgspec.Struct, frozen=True):
    """A backup.

    Parameters
    ----------
    id : str
        Time at which it was begun, in UTC, with random digits: ``20261130T010203.123456Z-1a2b3c``. Ids sort by time.
    begun, ended : float
        Times between which stores were read [s since the epoch].
    stores : dict of str to str
        Scheme of each store that was read, such as ``{"store": "sqlite", "map_store": "file"}``.
    at_once : bool
        Whether all records but maps are of one moment. They are of SQLite; another store may change while it is read.
    streams : dict of str to BackupStream
        Records by kind.
    logs : tuple of CloneLog
    versions : dict
        Files of the map versions that the maps name.
    epochs : dict of str to int
        Epochs of leases.
    added, size : int
        Bytes that this backup has added to the repository, and uncompressed bytes of all its blocks.
    files : tuple of StoredFile
        Files of the data folder.
    """

    id: str
    begun: float
    ended: float
    stores: dict[str, str]
    at_once: bool
    streams: dict[str, BackupStream]
    logs: tuple[CloneLog, ...] = ()
    versions: Versions = {}
    epochs: dict[str, int] = {}
    added: int = 0
    size: int = 0
    format: int = FORMAT_OF_RECORDS
    release: str = __version__
    files: tuple[StoredFile, ...] = ()

    def blocks(self) -> set[str]:
        """Return the names of all blocks that it needs."""
        streams = self.streams.values()
        names = {block.name for stream in streams for block in stream.blocks}
        names |= {stream.index for stream in streams if stream.index}
        names |= {block.name for log in self.logs for block in log.blocks}
        names |= {name for file in self.files for name in file.blocks}
        return names | {name for parts in self.versions.values() for part in parts.values() for name in part.blocks}


def new_id() -> str:
    """Return the id of a backup that begins now."""
    return f"{datetime.now(UTC):%Y%m%dT%H%M%S.%fZ}-{secrets.token_hex(3)}"
