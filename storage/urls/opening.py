"""Stores by URL. What keeps them is imported when it is asked for: nobody needs a driver that they don't use.

``memory:``, ``sqlite:///path/to/file``, ``file:///path/to/folder``, ``cassandra://host/keyspace``, ``hdfs://host/path``;
``sqlite:file`` and ``file:folder`` are relative to the working directory. ``?granularity=N`` behind an SQLite file says
from about how many waypoints on a stretch that plans share is kept once.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote, urlsplit

from ppaas.errors import InvalidInput, NotFound
from storage.ports import MapStore, Store


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


def _sqlite(url: str) -> tuple[Path] | tuple[Path, int]:
    path, question, query = url.partition("?")
    name, _, value = query.partition("=")
    if not question:
        return _local_path(path)
    if name != "granularity" or not value.isdecimal():
        raise InvalidInput(f"{url!r}: behind '?' comes granularity=N, in waypoints; write '?' in a path as %3F")
    return (*_local_path(path), int(value))


def _whole(url: str) -> tuple[str]:
    return (url,)


@dataclass(frozen=True, slots=True)
class Backend:
    """What keeps the stores of one scheme.

    Parameters
    ----------
    module, name : str
        Where the class is.
    arguments : callable
        Makes its arguments of the URL.
    extra : str, optional
        What must be installed beside the cloud.
    remote : bool
        Another program keeps it, which may be away while this one runs.
    """

    module: str
    name: str
    arguments: Callable[[str], tuple[Any, ...]]
    extra: str | None = None
    remote: bool = False


STORES = {
    "memory": Backend("storage.memory.store", "MemoryStore", _nothing),
    "sqlite": Backend("storage.sqlite.store", "SqliteStore", _sqlite),
    "cassandra": Backend("storage.cassandra.store", "CassandraStore", _whole, extra="cassandra", remote=True),
}

MAP_STORES = {
    "memory": Backend("storage.memory.maps", "MemoryMapStore", _nothing),
    "file": Backend("storage.files.store", "FileMapStore", _local_path),
    "hdfs": Backend("storage.hdfs.store", "HdfsMapStore", _whole, extra="hdfs", remote=True),
}


def open_store(url: str, *, outbox: Path | None = None) -> Store:
    """Open what keeps everything but maps.

    Parameters
    ----------
    url : str
        Where it is.
    outbox : Path, optional
        File in which plans wait while a store of another program is away.

    Raises
    ------
    InvalidInput
        Not a URL of a known scheme, or one whose extra is not installed.
    Unavailable
        It cannot be opened now; the text says why and what to do.
    """
    store = cast(Store, _open(url, STORES))
    if outbox is None or not STORES[url.partition(":")[0]].remote:
        return store
    from storage.store_and_forward.plan_outbox import Outbox  # noqa: PLC0415
    from storage.store_and_forward.store import PatientStore  # noqa: PLC0415 - nobody needs them who keeps all on this machine

    return cast(Store, PatientStore(store, Outbox(outbox)))


def open_map_store(url: str) -> MapStore:
    """Open what keeps maps; raises as ``open_store`` does."""
    return cast(MapStore, _open(url, MAP_STORES))


def check_exists(url: str) -> None:
    """Raise ``NotFound`` if a URL is a path where nothing is: who opened it would make an empty store."""
    scheme = url.partition(":")[0]
    backend = STORES.get(scheme, MAP_STORES.get(scheme))
    arguments = () if backend is None else backend.arguments(url)
    if any(isinstance(path, Path) and not path.exists() for path in arguments):
        raise NotFound("store", url)


def _open(url: str, backends: dict[str, Backend]) -> Any:
    scheme, colon, _ = url.partition(":")
    backend = backends.get(scheme) if colon else None
    if backend is None:
        raise InvalidInput(f"unknown kind of store {scheme!r}; known: {', '.join(f'{name}:' for name in backends)}")
    arguments = backend.arguments(url)
    try:
        kind = getattr(import_module(backend.module), backend.name)
    except ModuleNotFoundError as error:
        if backend.extra is None:
            raise
        hint = f"pip install 'ppaas[{backend.extra}]'"
        if error.name == backend.module:
            hint = f"this release does not have them yet; the one that does wants {hint}"
        raise InvalidInput(f"{scheme}: stores are not installed: {hint}") from error
    return kind(*arguments)
