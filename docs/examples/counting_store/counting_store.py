"""A custom store: SQLite's, which counts the calls of each method and logs them when it is closed."""

import logging
import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from storage.ports import Store
from storage.sqlite.store import SqliteStore
from storage.urls.backends import local_path_of
from storage.urls.base import StoreBackend

logger = logging.getLogger(__name__)


class CountingStore:
    """Passes all calls on to another store."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._lock = threading.Lock()  # a store is called from many threads
        self.calls: Counter[str] = Counter()

    def __getattr__(self, name: str) -> Callable[..., Any]:
        method = getattr(self._store, name)

        def counted(*arguments: Any, **keywords: Any) -> Any:
            with self._lock:
                self.calls[name] += 1
            return method(*arguments, **keywords)

        return counted

    def close(self) -> None:
        often = ", ".join(f"{name} {count}" for name, count in self.calls.most_common())
        logger.info("the store was called %d times: %s", self.calls.total(), often)
        self._store.close()


class Counting(StoreBackend):
    """Opens ``counting:///path/to/file``; the scheme is the name of the entry point."""

    def path(self, url: str) -> Path:
        return local_path_of(url)

    def open(self, url: str, *, create: bool = True) -> Store:
        return cast(Store, CountingStore(SqliteStore(local_path_of(url))))
