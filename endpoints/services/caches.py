"""Caches of a process of a cloud drop what another process changed, and announce what this one changes."""

from functools import partial
from typing import Any

from endpoints.services.services import Services
from engine.service.news import NewsKind
from storage.store_cache import StoreCache


class Caches:
    """Connects the caches of this process with the caches of others.

    Parameters
    ----------
    services : Services
        Services with the caches.
    """

    def __init__(self, services: Services) -> None:
        self._accounts = services.accounts
        self._caches: dict[NewsKind, StoreCache[Any]] = {"map": services.map_cache, "robot": services.shares}
        for kind, cache in self._caches.items():
            cache.announce = partial(services.cloud.announce, kind)

    def hear(self, kind: NewsKind, key: str) -> None:
        """Drop a record that another process has changed."""
        if kind == "user":
            self._accounts.forget_user(key)
        cache = self._caches.get(kind)
        if cache is not None:
            cache.drop(key)

    def drop_all(self) -> None:
        """Drop everything, as news may have been missed."""
        for cache in self._caches.values():
            cache.drop_all()
        self._accounts.forget_all()
