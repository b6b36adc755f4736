"""Opens stores by URL.

``memory:``, ``sqlite:///path/to/file``, ``file:///path/to/folder``, ``cassandra://host/keyspace``, ``hdfs://host/path``;
``sqlite:file`` and ``file:folder`` are relative to the working directory. ``?granularity=N`` behind an SQLite file says
from about how many waypoints on a stretch that plans share is kept once.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar, cast

from ppaas.errors import InvalidInput, NotFound
from storage.ports import MapStore, Store
from storage.urls.backends import MAP_STORES, STORES, Backend

S = TypeVar("S")


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
    store = _open(url, STORES)
    if outbox is None or not STORES[url.partition(":")[0]].remote:
        return store
    # Imported here, as nobody needs them who keeps everything on this machine.
    from storage.store_and_forward.plan_outbox import Outbox  # noqa: PLC0415
    from storage.store_and_forward.store import PatientStore  # noqa: PLC0415

    return cast(Store, PatientStore(store, Outbox(outbox)))


def open_map_store(url: str) -> MapStore:
    """Open what keeps maps; raises as ``open_store`` does."""
    return _open(url, MAP_STORES)


def check_exists(url: str) -> None:
    """Raise ``NotFound`` if a URL is a path where nothing is: who opened it would make an empty store."""
    scheme = url.partition(":")[0]
    backend = STORES.get(scheme) or MAP_STORES.get(scheme)
    arguments = () if backend is None else backend.arguments(url)
    if any(isinstance(path, Path) and not path.exists() for path in arguments):
        raise NotFound("store", url)


def _open(url: str, backends: Mapping[str, Backend[S]]) -> S:
    scheme, colon, _ = url.partition(":")
    backend = backends.get(scheme) if colon else None
    if backend is None:
        raise InvalidInput(f"unknown kind of store {scheme!r}; known: {', '.join(f'{name}:' for name in backends)}")
    arguments = backend.arguments(url)
    try:
        kind = backend.load()
    except ModuleNotFoundError as error:
        if backend.extra is None:
            raise
        raise InvalidInput(f"{scheme}: stores are not installed: pip install 'ppaas[{backend.extra}]'") from error
    return kind(*arguments)
