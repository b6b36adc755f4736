"""Maps in HDFS, over WebHDFS, in the layout of ``storage.files.map_log``.

A file is written under a unique name in ``.incoming`` and then renamed. A rename in HDFS is atomic and never replaces a
file: so no file under its final name is incomplete, and of several writers of the same log entry one succeeds. No lease
and no lock is held. Files that a killed writer left in ``.incoming`` are removed after a day.
"""

import getpass
import logging
import posixpath
import uuid
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from urllib.parse import parse_qs, unquote, urlsplit

from hdfs import HdfsError, InsecureClient
from requests import RequestException

from ppaas.bounded import BoundedDict
from ppaas.clock import epoch
from ppaas.errors import InvalidInput, NotFound, Unavailable
from storage.files.reviewed_maps import ReviewedMapStore
from storage.records import MapRecord
from storage.staged_uploads import BLOCK, blocks, mapped
from storage.store_errors import disk_errors, unusable
from storage.temporary import temporary_folder

logger = logging.getLogger(__name__)


PORT = 9870
"""Default port of a NameNode's HTTP server (``dfs.namenode.http-address``)."""

_TIMEOUT = (5.0, 30.0)
"""Time limits to connect, and between two packets of a response [s]."""


@dataclass(frozen=True, slots=True)
class HdfsAddress:
    """A folder in HDFS.

    Parameters
    ----------
    host : str
        Host name or address of the NameNode, with its port.
    path : str
        Absolute path of the folder.
    user : str
        HDFS user that reads and writes it.
    """

    host: str
    path: str
    user: str

    @classmethod
    def parse(cls, url: str) -> "HdfsAddress":
        """Parse a URL; ``InvalidInput`` if it is not valid."""
        try:
            parts = urlsplit(url)
            host, port = parts.hostname, parts.port or PORT
            query = parse_qs(parts.query, strict_parsing=True, keep_blank_values=True) if parts.query else {}
        except ValueError as error:
            raise InvalidInput(f"{url!r} is not a URL: {error}") from error
        path = unquote(parts.path).rstrip("/")
        names = path.split("/")[1:]
        if not host or not names or any(name in ("", ".", "..") or "#" in name for name in names):
            raise InvalidInput(
                f"{url!r} has no valid host or folder: write hdfs://host[:port]/path, optionally with ?user=name"
            )
        users = query.pop("user", None) or [getpass.getuser()]
        if query or parts.fragment or parts.username or len(users) > 1 or not users[0]:
            raise InvalidInput(f"{url!r}: only ?user=name may follow the path, and nothing may precede the host")
        return cls(f"[{host}]:{port}" if ":" in host else f"{host}:{port}", path, users[0])

    def __str__(self) -> str:
        return f"hdfs://{self.host}{self.path}"

    def client(self) -> InsecureClient:
        """Return a WebHDFS client."""
        return InsecureClient(f"http://{self.host}", user=self.user, timeout=_TIMEOUT)


# Errors of HDFS and its client become ``Unavailable`` with advice for the operator.

_STARTING = "the NameNode is starting or in standby: wait, or give the address of the active one"
_QUOTA = "the quota of the folder is used up: free space, or raise the quota"
_ADVICE = {
    "AccessControlException": "permission denied: give user {user!r} read and write access, or set another ?user=name",
    "SecurityException": "user {user!r} is refused: set another one with ?user=name",
    "SafeModeException": "HDFS is in safe mode: wait until its DataNodes have reported, or end safe mode",
    "RetriableException": _STARTING,
    "StandbyException": _STARTING,
    "DSQuotaExceededException": _QUOTA,
    "NSQuotaExceededException": _QUOTA,
}
_MISSING = "FileNotFoundException"
_MAX_TEXT = 200


@contextmanager
def hdfs_errors(address: HdfsAddress) -> Iterator[None]:
    """Turn errors of the client into ``Unavailable``, and those for a missing file into ``FileNotFoundError``."""
    try:
        yield
    except HdfsError as error:
        if error.exception == _MISSING:
            raise FileNotFoundError(str(error)) from error
        raise unusable(address, _advice(error, address)) from error
    except RequestException as error:
        reason = type(error).__name__
        raise unusable(
            address, f"cannot reach the NameNode or a DataNode ({reason}): check that both are running"
        ) from error
    except (KeyError, TypeError) as error:
        raise unusable(address, "the server does not speak WebHDFS: give the HTTP port of the NameNode") from error


def _advice(error: HdfsError, address: HdfsAddress) -> str:
    known = _ADVICE.get(error.exception or "")
    if known is not None:
        return known.format(user=address.user)
    return f"HDFS failed ({str(error)[:_MAX_TEXT]}): check that its DataNodes are running and have free space"


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
