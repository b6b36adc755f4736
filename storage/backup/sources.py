"""Stores that are backed up or restored, opened by their URLs."""

import sqlite3
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

from storage.backup.writing import Sources
from storage.ports import MapStore, Store
from storage.store_errors import disk_errors, unusable
from storage.temporary import sweep_temporary_folders, temporary_folder
from storage.urls.opening import local_path, open_existing_map_store, open_existing_store, open_map_store, open_store
from storage.urls.registry import scheme_of

SQLITE = "sqlite"


@contextmanager
def existing(
    store: str | None, map_store: str | None, folder: Path = Path(), files: tuple[str, ...] = ()
) -> Iterator[Sources]:
    """Open stores to read everything in them.

    The file of SQLite is copied first, beside itself, by SQLite's online backup: the copy is of one moment, and the
    cloud goes on writing meanwhile.

    Parameters
    ----------
    store, map_store : str, optional
        URLs of existing stores.
    folder, files
        Data folder, and the files in it that are backed up too.

    Raises
    ------
    NotFound, InvalidInput, Unavailable
        A store cannot be opened.
    """
    with ExitStack() as stack:
        sources = Sources(folder=folder, files=files)
        if store is not None:
            sources.schemes["store"] = scheme_of(store)
            sources.at_once = scheme_of(store) == SQLITE
            opened = open_existing_store(stack.enter_context(_copied(store)) if sources.at_once else store)
            sources.store = stack.enter_context(closing(opened))
        if map_store is not None:
            sources.schemes["map_store"] = scheme_of(map_store)
            sources.map_store = _closed_with(stack, open_existing_map_store(map_store))
        yield sources


@contextmanager
def targets(store: str, map_store: str) -> Iterator[tuple[Store, MapStore]]:
    """Open stores to restore records into; they are created if they do not exist. Errors are as for ``existing``."""
    with ExitStack() as stack:
        opened = stack.enter_context(closing(open_store(store)))
        yield opened, _closed_with(stack, open_map_store(map_store))


def _closed_with(stack: ExitStack, store: Any) -> Any:
    return stack.enter_context(closing(store)) if hasattr(store, "close") else store


@contextmanager
def _copied(url: str) -> Iterator[str]:
    """Copy the file of an SQLite store; yield the URL of the copy."""
    path = local_path(url)
    assert path is not None
    settings = url.partition("?")[2]
    if not path.is_file():
        yield url  # opening it reports what is wrong
        return
    sweep_temporary_folders(path.parent)
    with temporary_folder(path.parent) as folder:
        copy = folder / path.name
        with disk_errors(path):
            _copy(path, copy)
        yield f"{SQLITE}:///{copy.absolute()}" + (f"?{settings}" if settings else "")


def _copy(path: Path, copy: Path) -> None:
    try:
        with (
            closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as source,
            closing(sqlite3.connect(copy)) as target,
        ):
            source.backup(target)
    except sqlite3.Error as error:
        raise unusable(path, str(error)) from error
