"""The project's own backends of stores. Each imports its store, and with it a driver, when it opens one."""

# ruff: noqa: PLC0415 - a driver is imported with the store that needs it

from pathlib import Path
from typing import ClassVar
from urllib.parse import unquote, urlsplit

from ppaas.errors import InvalidInput
from storage.ports import MapStore, Store
from storage.urls.base import MapStoreBackend, StoreBackend


class Memory(StoreBackend):
    """``memory:``."""

    def open(self, url: str, *, create: bool = True) -> Store:
        """Return an empty store."""
        from storage.memory.store import MemoryStore

        return MemoryStore()


class Sqlite(StoreBackend):
    """``sqlite:///path/to/file``, or ``sqlite:file``."""

    def path(self, url: str) -> Path:
        """Return the file."""
        return _path_and_granularity(url)[0]

    def open(self, url: str, *, create: bool = True) -> Store:
        """Open the store in a file."""
        from storage.sqlite.store import SqliteStore

        return SqliteStore(*_path_and_granularity(url))


class Cassandra(StoreBackend):
    """``cassandra://host/keyspace``."""

    extra: ClassVar[str | None] = "cassandra"
    remote: ClassVar[bool] = True
    takes_password: ClassVar[bool] = True

    def open(self, url: str, *, create: bool = True) -> Store:
        """Connect to the cluster."""
        from storage.cassandra.store import CassandraStore

        return CassandraStore(url, create=create)


class MemoryMaps(MapStoreBackend):
    """``memory:``."""

    def open(self, url: str, *, create: bool = True) -> MapStore:
        """Return an empty store."""
        from storage.memory.maps import MemoryMapStore

        return MemoryMapStore()


class Files(MapStoreBackend):
    """``file:///path/to/folder``, or ``file:folder``."""

    def path(self, url: str) -> Path:
        """Return the folder."""
        return local_path_of(url)

    def is_store(self, path: Path) -> bool:
        """Return whether a folder is a store of maps."""
        from storage.files.store import is_store

        return is_store(path)

    def open(self, url: str, *, create: bool = True) -> MapStore:
        """Open the store in a folder."""
        from storage.files.store import FileMapStore

        return FileMapStore(local_path_of(url))


class Hdfs(MapStoreBackend):
    """``hdfs://host/path``."""

    extra: ClassVar[str | None] = "hdfs"
    remote: ClassVar[bool] = True

    def open(self, url: str, *, create: bool = True) -> MapStore:
        """Connect to the name node."""
        from storage.hdfs.store import HdfsMapStore

        return HdfsMapStore(url, create=create)


def local_path_of(url: str) -> Path:
    """Return the path of a URL such as ``sqlite:///absolute/path`` or ``sqlite:relative``.

    Raises
    ------
    InvalidInput
        It has a host, a query or no path.
    """
    try:
        parts = urlsplit(url)
    except ValueError as error:
        raise InvalidInput(f"{url!r} is not a URL: {error}") from error
    if parts.netloc or not parts.path.strip("/"):
        raise InvalidInput(f"{url!r} has no path: write {parts.scheme}:///absolute/path or {parts.scheme}:relative")
    if parts.query or parts.fragment:
        raise InvalidInput(f"{url!r}: write '?' as %3F and '#' as %23 in a path")
    return Path(unquote(parts.path))


def _path_and_granularity(url: str) -> tuple[Path] | tuple[Path, int]:
    path, question, query = url.partition("?")
    name, _, value = query.partition("=")
    if not question:
        return (local_path_of(path),)
    if name != "granularity" or not value.isdecimal():
        raise InvalidInput(f"{url!r}: only granularity=N [waypoints] may follow '?'; write '?' in a path as %3F")
    return local_path_of(path), int(value)
