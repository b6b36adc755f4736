"""Maps in HDFS, by WebHDFS, as ``storage.files.map_log`` lays them out.

A file is written under a name of its own in ``.incoming`` and then renamed, which HDFS does at once and never onto a
file that is there: so no file under its right name is half-written, and of those who write the same entry of a log one
does. No lease and no lock is held. What a killed writer left in ``.incoming`` is removed a day later.
"""

import posixpath
import uuid
from collections import OrderedDict
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from threading import Lock

from hdfs import HdfsError

from ppaas.clock import epoch
from ppaas.errors import Unavailable
from storage.disk_errors import disk_errors
from storage.files.map_log import LoggedMapStore
from storage.hdfs.address import HdfsAddress
from storage.hdfs.errors import hdfs_errors
from storage.records import MapRecord
from storage.staged_uploads import BLOCK, blocks, mapped, temporary_folder

_INCOMING = ".incoming"
_STALE = 24 * 3600.0
"""Age at which what lies in ``.incoming`` is nobody's any more [s]."""

_ATTEMPTS = 3
_REMEMBERED = 4096
"""Heads that are told again while HDFS is away."""


class HdfsMapStore(LoggedMapStore):
    """A ``MapStore`` in HDFS.

    While HDFS is away, the heads of maps that were looked up before are told as they were: nobody can change them
    meanwhile, and a robot whose map is prepared on its machine goes on. Everything else is ``Unavailable``.

    Parameters
    ----------
    url : str
        ``hdfs://host[:port]/path[?user=name]``; the port is that of the NameNode's HTTP server, 9870 by default.

    Raises
    ------
    InvalidInput
        No such URL.
    """

    def __init__(self, url: str) -> None:
        super().__init__(HdfsDisk(HdfsAddress.parse(url)))
        self._heads: OrderedDict[str, MapRecord] = OrderedDict()
        self._lock = Lock()

    def map_head(self, map_id: str) -> MapRecord:
        """Return a map in its present version, or while HDFS is away in the one that was known last."""
        try:
            head = super().map_head(map_id)
        except Unavailable:
            with self._lock:
                if map_id not in self._heads:
                    raise
                return self._heads[map_id]
        with self._lock:
            self._heads[map_id] = head
            self._heads.move_to_end(map_id)
            if len(self._heads) > _REMEMBERED:
                self._heads.popitem(last=False)
        return head


class HdfsDisk:
    """A ``Disk`` that is a folder of HDFS.

    Parameters
    ----------
    address : HdfsAddress
        Where it is.
    """

    def __init__(self, address: HdfsAddress) -> None:
        self._address = address
        self._client = address.client()

    def folders(self) -> list[str]:
        """Return the names of the folders at the top."""
        return self.names("")

    def names(self, folder: str) -> list[str]:
        """Return what is in a folder; nothing if there is none."""
        try:
            with self._told():
                names: list[str] = self._client.list(self._path(folder))
                return names
        except FileNotFoundError:
            return []

    def read(self, path: str) -> bytes:
        """Return a small file; ``FileNotFoundError`` if there is none."""
        with self._told(), self._client.read(self._path(path), chunk_size=BLOCK) as data:
            return b"".join(data)

    def create(self, path: str, data: bytes) -> bool:
        """Keep a small file; tell whether it is new."""
        with self._told():
            return self._take_place(self._written([data]), path)

    def place(self, source: Path, path: str) -> None:
        """Keep a copy of a local file, unless it is there: it was whole when it was renamed."""
        with disk_errors(source):
            data = mapped(source)
        with self._told():
            there = self._client.status(self._path(path), strict=False)
            if there is None or there["length"] != len(data):
                self._client.delete(self._path(path))
                self._take_place(self._written(blocks(data)), path)

    @contextmanager
    def opened(self, path: str) -> Iterator[Path]:
        """Fetch a file for a while; ``FileNotFoundError`` if there is none."""
        with temporary_folder() as folder:
            file = folder / "file"
            with disk_errors(folder, but=FileNotFoundError), self._told():
                self._fetch(path, file)
            yield file

    def _fetch(self, path: str, file: Path) -> None:
        with self._client.read(self._path(path), chunk_size=BLOCK) as data, file.open("wb") as kept:
            for block in data:
                kept.write(block)

    def remove(self, path: str) -> None:
        """Forget a file, or a folder with all that is in it, if there is one."""
        with self._told():
            self._client.delete(self._path(path), recursive=True)

    @contextmanager
    def drafting(self) -> Iterator[Path]:
        """Make a folder on this machine, and remove what killed writers left in HDFS long ago."""
        self._sweep()
        with temporary_folder() as folder:
            yield folder

    def _sweep(self) -> None:
        before = 1e3 * (epoch() - _STALE)
        with suppress(FileNotFoundError), self._told():
            for name, status in self._client.list(self._path(_INCOMING), status=True):
                if status["modificationTime"] < before:
                    self._client.delete(self._path(f"{_INCOMING}/{name}"))

    def _written(self, data: Iterable[bytes]) -> str:
        """Write a file under a name that no other has; return that."""
        path = self._path(f"{_INCOMING}/{uuid.uuid4().hex}")
        self._client.write(path, data=iter(data))
        return path

    def _take_place(self, written: str, path: str) -> bool:
        """Give a file its name; tell whether that was free. What had none goes."""
        try:
            for _ in range(_ATTEMPTS):
                if self._renamed(written, self._path(path)):
                    return True
                if self._client.status(self._path(path), strict=False) is not None:
                    break
                self._client.makedirs(posixpath.dirname(self._path(path)))
            else:
                raise HdfsError(f"{path} can be given to no file")
        except HdfsError:
            self._client.delete(written)
            raise
        self._client.delete(written)
        return False

    def _renamed(self, source: str, target: str) -> bool:
        try:
            self._client.rename(source, target)
        except HdfsError as error:
            if error.exception is None:  # HDFS answered, and did not: the name is taken, or its folder is missing
                return False
            raise
        return True

    def _told(self) -> AbstractContextManager[None]:
        return hdfs_errors(self._address)

    def _path(self, path: str) -> str:
        return posixpath.join(self._address.path, path) if path else self._address.path
