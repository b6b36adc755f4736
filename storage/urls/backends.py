"""The backends of stores, by the scheme of their URLs.

Each is imported by a function of its own when it is asked for, so that nobody needs a driver that they don't use.
"""

# ruff: noqa: PLC0415 - a driver is loaded with the backend that needs it

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar
from urllib.parse import unquote, urlsplit

from ppaas.errors import InvalidInput
from storage.ports import MapStore, Store

S = TypeVar("S")


@dataclass(frozen=True, slots=True)
class Backend(Generic[S]):
    """A class of stores, and how it is made of a URL.

    Parameters
    ----------
    load : callable
        Imports the class and returns it.
    arguments : callable
        Makes the arguments of the class from the URL.
    extra : str, optional
        The extra of ``ppaas`` that brings its driver.
    remote : bool
        Whether another program keeps the data, which may be away while this one runs.
    """

    load: Callable[[], Callable[..., S]]
    arguments: Callable[[str], tuple[Any, ...]]
    extra: str | None = None
    remote: bool = False


def _memory() -> Callable[..., Store]:
    from storage.memory.store import MemoryStore

    return MemoryStore


def _sqlite() -> Callable[..., Store]:
    from storage.sqlite.store import SqliteStore

    return SqliteStore


def _cassandra() -> Callable[..., Store]:
    from storage.cassandra.store import CassandraStore

    return CassandraStore


def _memory_maps() -> Callable[..., MapStore]:
    from storage.memory.maps import MemoryMapStore

    return MemoryMapStore


def _files() -> Callable[..., MapStore]:
    from storage.files.store import FileMapStore

    return FileMapStore


def _hdfs() -> Callable[..., MapStore]:
    from storage.hdfs.store import HdfsMapStore

    return HdfsMapStore


def _nothing(_url: str) -> tuple[()]:
    return ()


def _local_path(url: str) -> tuple[Path]:
    try:
        parts = urlsplit(url)
    except ValueError as error:
        raise InvalidInput(f"{url!r} is no URL: {error}") from error
    if parts.netloc or not parts.path.strip("/"):
        raise InvalidInput(f"{url!r} names no path: write {parts.scheme}:///absolute/path or {parts.scheme}:relative")
    if parts.query or parts.fragment:
        raise InvalidInput(f"{url!r}: write '?' as %3F and '#' as %23 in a path")
    return (Path(unquote(parts.path)),)


def _path_and_granularity(url: str) -> tuple[Path] | tuple[Path, int]:
    path, question, query = url.partition("?")
    name, _, value = query.partition("=")
    if not question:
        return _local_path(path)
    if name != "granularity" or not value.isdecimal():
        raise InvalidInput(f"{url!r}: behind '?' comes granularity=N, in waypoints; write '?' in a path as %3F")
    return (*_local_path(path), int(value))


def _whole(url: str) -> tuple[str]:
    return (url,)


STORES: dict[str, Backend[Store]] = {
    "memory": Backend(_memory, _nothing),
    "sqlite": Backend(_sqlite, _path_and_granularity),
    "cassandra": Backend(_cassandra, _whole, extra="cassandra", remote=True),
}

MAP_STORES: dict[str, Backend[MapStore]] = {
    "memory": Backend(_memory_maps, _nothing),
    "file": Backend(_files, _local_path),
    "hdfs": Backend(_hdfs, _whole, extra="hdfs", remote=True),
}
