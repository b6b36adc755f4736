"""Backends of stores, by URL scheme.

A function for each backend imports it on demand, so a driver must be installed only where it is used.
"""

# ruff: noqa: PLC0415 - a driver is imported with the backend that needs it

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
    """A class of stores, and how to construct it from a URL.

    Parameters
    ----------
    load : callable
        Imports the class and returns it.
    arguments : callable
        Parses the URL into the arguments of the class.
    extra : str, optional
        Extra of ``ppaas`` that installs its driver.
    remote : bool
        Whether a server stores the data, which may be unreachable while this process runs. Its class takes
        ``create=False`` to raise an error for a store that does not exist.
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


def _no_arguments(_url: str) -> tuple[()]:
    return ()


def _local_path(url: str) -> tuple[Path]:
    try:
        parts = urlsplit(url)
    except ValueError as error:
        raise InvalidInput(f"{url!r} is not a URL: {error}") from error
    if parts.netloc or not parts.path.strip("/"):
        raise InvalidInput(f"{url!r} has no path: write {parts.scheme}:///absolute/path or {parts.scheme}:relative")
    if parts.query or parts.fragment:
        raise InvalidInput(f"{url!r}: write '?' as %3F and '#' as %23 in a path")
    return (Path(unquote(parts.path)),)


def _path_and_granularity(url: str) -> tuple[Path] | tuple[Path, int]:
    path, question, query = url.partition("?")
    name, _, value = query.partition("=")
    if not question:
        return _local_path(path)
    if name != "granularity" or not value.isdecimal():
        raise InvalidInput(f"{url!r}: only granularity=N [waypoints] may follow '?'; write '?' in a path as %3F")
    return (*_local_path(path), int(value))


def _url_itself(url: str) -> tuple[str]:
    return (url,)


STORES: dict[str, Backend[Store]] = {
    "memory": Backend(_memory, _no_arguments),
    "sqlite": Backend(_sqlite, _path_and_granularity),
    "cassandra": Backend(_cassandra, _url_itself, extra="cassandra", remote=True),
}

MAP_STORES: dict[str, Backend[MapStore]] = {
    "memory": Backend(_memory_maps, _no_arguments),
    "file": Backend(_files, _local_path),
    "hdfs": Backend(_hdfs, _url_itself, extra="hdfs", remote=True),
}
