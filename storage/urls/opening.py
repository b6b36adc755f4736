"""Opens stores by URL.

``memory:``, ``sqlite:///path/to/file``, ``file:///path/to/folder``, ``cassandra://host/keyspace``, ``hdfs://host/path``;
``sqlite:file`` and ``file:folder`` are relative to the working directory. ``?granularity=N`` after an SQLite file sets
the length from which segments of plans are shared, about [waypoints]. ``?password_file=FILE`` after the URL of a store
that takes a password (``storage.urls.passwords``) reads it from a file. Other distributions add schemes by entry points
in the groups ``ppaas.stores`` and ``ppaas.map_stores``.
"""

from pathlib import Path
from typing import TypeVar, cast

from ppaas.distribution import check_versions, install_hint
from ppaas.errors import InvalidInput, NotFound
from ppaas.tracing.spans import traced
from storage.disk_space import DiskReserve, GuardedStore
from storage.ports import MapStore, Store
from storage.urls.base import Backend
from storage.urls.passwords import with_password
from storage.urls.registry import MAP_STORES, STORES, backend_of, scheme_of

S = TypeVar("S", Store, MapStore)


def open_store(url: str, *, outbox: Path | None = None, reserve: Path | None = None) -> Store:
    """Open the store of everything but maps.

    Parameters
    ----------
    url : str
        URL of the store.
    outbox : Path, optional
        File in which plans wait while a remote store is unreachable.
    reserve : Path, optional
        Folder with the reserve of disk space of a cloud; a store on the same disk stores nothing new when it is full.

    Raises
    ------
    InvalidInput
        The scheme is unknown, the rest of the URL is not valid, or the extra of the backend is not installed.
    NotPermitted, BrokenPlugin
        The backend is of another distribution, and is not allowed, or cannot be loaded.
    Unavailable
        The store cannot be opened now; the message says why and what to do.
    """
    url = with_password(url)
    backend = backend_of(url, STORES)
    store = traced(_guarded(_open(backend, url), url, reserve), "store")
    if outbox is None or not backend.remote:
        return store
    # Imported here because only remote stores need them.
    from storage.store_and_forward.plan_outbox import PlanOutbox  # noqa: PLC0415
    from storage.store_and_forward.store import StoreAndForward  # noqa: PLC0415

    return cast(Store, StoreAndForward(store, PlanOutbox(outbox)))


def open_map_store(url: str, *, reserve: Path | None = None) -> MapStore:
    """Open the store of maps; parameters and errors are the same as for ``open_store``."""
    url = with_password(url)
    return traced(_guarded(_open(backend_of(url, MAP_STORES), url), url, reserve), "map store")


def open_existing_store(url: str) -> Store:
    """Open a store of everything but maps that exists: nothing is created where a URL is mistyped.

    Raises
    ------
    NotFound
        There is no such store. One in Cassandra is looked for with the first request, which raises ``Unavailable``.
    InvalidInput, Unavailable
        As for ``open_store``.
    """
    check_exists(url)
    return _open(backend_of(url, STORES), with_password(url), create=False)


def open_existing_map_store(url: str) -> MapStore:
    """Open a store of maps that exists; errors are the same as for ``open_existing_store``."""
    check_exists(url)
    return _open(backend_of(url, MAP_STORES), with_password(url), create=False)


def local_path(url: str) -> Path | None:
    """Return the file or folder of a store on this machine, or None if a URL is not of such a store."""
    backend = _backend_of_any(url)
    return None if backend is None else backend.path(url)


def _backend_of_any(url: str) -> Backend[Store] | Backend[MapStore] | None:
    """Return the backend of a URL of any kind of store; None if there is none."""
    scheme = scheme_of(url)
    if scheme in STORES:
        return STORES.create(scheme, {})
    return MAP_STORES.create(scheme, {}) if scheme in MAP_STORES else None


def _guarded(store: S, url: str, reserve: Path | None) -> S:
    if reserve is None or not _on_same_disk(url, reserve):
        return store
    return cast(S, GuardedStore(store, DiskReserve(reserve)))


def _on_same_disk(url: str, reserve: Path) -> bool:
    path = local_path(url)
    try:
        return path is not None and path.parent.stat().st_dev == reserve.stat().st_dev
    except OSError:
        return False


def check_exists(url: str) -> None:
    """Raise ``NotFound`` if a URL is a path at which there is no store: opening it would create an empty one there."""
    backend = _backend_of_any(url)
    path = None if backend is None else backend.path(url)
    if backend is None or path is None:
        return
    if not path.exists():
        raise NotFound("store", url)
    if path.is_file() and not path.stat().st_size:
        raise NotFound("store", url, advice="the file is empty: restore it from a backup, or correct the path")
    if path.is_dir() and not backend.is_store(path):
        raise NotFound("store", url, advice="the folder is none of a store: correct the path")


def is_same(first: str, second: str) -> bool:
    """Return whether two URLs are of one store, or of folders of which one is in the other."""
    paths = [path.resolve() for path in map(local_path, (first, second)) if path is not None]
    if len(paths) < len((first, second)):
        return first == second
    return paths[0].is_relative_to(paths[1]) or paths[1].is_relative_to(paths[0])


def _open(backend: Backend[S], url: str, *, create: bool = True) -> S:
    if backend.extra is not None:
        check_versions(backend.extra)
    try:
        return backend.open(url, create=create)
    except ModuleNotFoundError as error:
        if backend.extra is None:
            raise
        raise InvalidInput(f"{scheme_of(url)}: stores need an extra: {install_hint(backend.extra)}") from error
