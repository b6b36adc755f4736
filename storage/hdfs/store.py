"""Maps in HDFS, over WebHDFS, in the layout of ``storage.files.map_log``.

A file is written under a unique name in ``.incoming`` and then renamed. A rename in HDFS is atomic and never replaces a
file: so no file under its final name is incomplete, and of several writers of the same log entry one succeeds. No lease
and no lock is held. Files that a killed writer left in ``.incoming`` are removed after a day.
"""

import logging
import posixpath
import uuid
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from threading import Lock

from hdfs import HdfsError
from requests import RequestException

from ppaas.bounded import BoundedDict
from ppaas.clock import epoch
from ppaas.errors import NotFound, Unavailable
from storage.disk_errors import disk_errors
from storage.files.reviewed_maps import ReviewedMapStore
from storage.hdfs.address import HdfsAddress
from storage.hdfs.errors import hdfs_errors
from storage.records import MapRecord
from storage.staged_uploads import BLOCK, blocks, mapped
from storage.temporary.folders import temporary_folder

logger = logging.getLogger(__name__)

_INCOMING = ".incoming"
_STALE = 24 * 3600.0
"""Age after which files in ``.incoming`` are removed [s]."""

_ATTEMPTS = 3
_MAX_HEADS = 4096
"""Largest number of heads that are cached for the time when HDFS is unreachable."""


class HdfsMapStore(ReviewedMapStore):
    """A ``MapStore`` in HDFS.

    While HDFS is unreachable, cached heads of maps are returned: nobody can change them meanwhile, and a robot whose
    map is prepared on its machine continues. Everything else raises ``Unavailable``.

    Parameters
    ----------
    url : str
        ``hdfs://host[:port]/path[?user=name]``; the port is the NameNode's HTTP port, 9870 by default.
    create : bool
        Whether the folder is created if it is missing, when a map is stored. Otherwise it must exist.

    Raises
    ------
    InvalidInput
        The URL is not valid.
    NotFound, Unavailable
        The folder must exist, and does not; or HDFS cannot be asked for it.
    """

    def __init__(self, url: str, *, create: bool = True) -> None:
        disk = HdfsDisk(HdfsAddress.parse(url))
        super().__init__(disk)
        if not create and not disk.exists():
            raise NotFound("store", url)
        self._heads: BoundedDict[str, MapRecord] = BoundedDict(_MAX_HEADS)
        self._lock = Lock()

    def map_head(self, map_id: str) -> MapRecord:
        """Return a map in its current version, or in the last known one while HDFS is unreachable."""
        try:
            head = super().map_head(map_id)
        except Unavailable:
            with self._lock:
                if map_id not in self._heads:
                    raise
                return self._heads[map_id]
        with self._lock:
            self._heads[map_id] = head
        return head


class HdfsDisk:
    """A ``Disk`` in a folder of HDFS.

    Parameters
    ----------
    address : HdfsAddress
        Address of the folder.
    """

    def __init__(self, address: HdfsAddress) -> None:
        self._address = address
        self._client = address.client()
        self._left: set[str] = set()

    def exists(self) -> bool:
        """Return whether the folder exists."""
        with self._errors():
            return self._client.status(self._path(""), strict=False) is not None

    def folders(self) -> list[str]:
        """Return the names of the top-level folders."""
        return self.names("")

    def names(self, folder: str) -> list[str]:
        """Return the names in a folder; an empty list if it does not exist."""
        try:
            with self._errors():
                names: list[str] = self._client.list(self._path(folder))
                return names
        except FileNotFoundError:
            return []

    def read(self, path: str) -> bytes:
        """Return the content of a small file; ``FileNotFoundError`` if it does not exist."""
        with self._errors(), self._client.read(self._path(path), chunk_size=BLOCK) as data:
            return b"".join(data)

    def create(self, path: str, data: bytes) -> bool:
        """Create a small file; return whether it is new."""
        with self._errors():
            return self._rename_to(self._write_temporary([data]), path)

    def place(self, source: Path, path: str) -> None:
        """Store a copy of a local file, unless a file of the same size exists: renamed files are complete."""
        with disk_errors(source):
            data = mapped(source)
        with self._errors():
            existing = self._client.status(self._path(path), strict=False)
            if existing is None or existing["length"] != len(data):
                self._client.delete(self._path(path))
                self._rename_to(self._write_temporary(blocks(data)), path)

    def move(self, source: str, target: str) -> bool:
        """Rename a file; return False if it does not exist."""
        with self._errors():
            self._client.delete(self._path(target))  # a rename in HDFS replaces no file
            return self._rename(self._path(source), self._path(target))

    @contextmanager
    def opened(self, path: str) -> Iterator[Path]:
        """Download a file for the time of the block; ``FileNotFoundError`` if it does not exist."""
        with temporary_folder() as folder:
            file = folder / "file"
            with disk_errors(folder, but=FileNotFoundError), self._errors():
                self._fetch(path, file)
            yield file

    def _fetch(self, path: str, file: Path) -> None:
        with self._client.read(self._path(path), chunk_size=BLOCK) as data, file.open("wb") as kept:
            for block in data:
                kept.write(block)

    def remove(self, path: str) -> None:
        """Remove a file, or a folder with its content, if it exists."""
        with self._errors():
            self._client.delete(self._path(path), recursive=True)

    @contextmanager
    def staging_folder(self) -> Iterator[Path]:
        """Create a local folder, and remove old files of killed writers in HDFS."""
        self._sweep()
        with temporary_folder() as folder:
            yield folder

    def _sweep(self) -> None:
        for path in list(self._left):
            self._discard(path)
        before = 1e3 * (epoch() - _STALE)
        with suppress(FileNotFoundError), self._errors():
            for name, status in self._client.list(self._path(_INCOMING), status=True):
                if status["modificationTime"] < before:
                    self._client.delete(self._path(f"{_INCOMING}/{name}"))

    def _write_temporary(self, data: Iterable[bytes]) -> str:
        """Write a file under a unique name in ``.incoming``; return its path."""
        path = self._path(f"{_INCOMING}/{uuid.uuid4().hex}")
        try:
            self._client.write(path, data=iter(data))
        except BaseException:  # a quota stops it in the middle, and what is written already counts
            self._discard(path)
            raise
        return path

    def _discard(self, path: str) -> None:
        """Delete a temporary file of this process; one that cannot be deleted now is deleted with the next upload."""
        try:
            self._client.delete(path)
        except (HdfsError, RequestException) as error:
            logger.warning("a part of a file stays in HDFS for now: %s: %s", path, error)
            self._left.add(path)
        else:
            self._left.discard(path)

    def _rename_to(self, written: str, path: str) -> bool:
        """Rename a temporary file to its final path; if that exists, delete the temporary file and return False."""
        try:
            for _ in range(_ATTEMPTS):
                if self._rename(written, self._path(path)):
                    return True
                if self._client.status(self._path(path), strict=False) is not None:
                    break
                self._client.makedirs(posixpath.dirname(self._path(path)))
            else:
                raise HdfsError(f"no file can be renamed to {path}")
        except (HdfsError, RequestException):
            self._discard(written)
            raise
        self._discard(written)
        return False

    def _rename(self, source: str, target: str) -> bool:
        try:
            self._client.rename(source, target)
        except HdfsError as error:
            if error.exception is None:  # refused by HDFS: the path exists, or its folder is missing
                return False
            raise
        return True

    def _errors(self) -> AbstractContextManager[None]:
        return hdfs_errors(self._address)

    def _path(self, path: str) -> str:
        return posixpath.join(self._address.path, path) if path else self._address.path
