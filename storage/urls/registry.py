"""Registries of the backends of stores, by URL scheme: our own, and those of other distributions by entry point."""

from typing import Any, TypeVar

from ppaas.errors import InvalidInput, NotFound
from ppaas.plugins import PluginRegistry
from storage.urls.base import Backend, MapStoreBackend, StoreBackend

B = TypeVar("B", bound=Backend[Any])

STORES: PluginRegistry[StoreBackend] = PluginRegistry("ppaas.stores", "store", StoreBackend, {})  # type: ignore[type-abstract]

MAP_STORES: PluginRegistry[MapStoreBackend] = PluginRegistry("ppaas.map_stores", "map store", MapStoreBackend, {})  # type: ignore[type-abstract]


def scheme_of(url: str) -> str:
    """Return the scheme of a URL; empty if it has none."""
    scheme, colon, _ = url.partition(":")
    return scheme if colon else ""


def backend_of(url: str, backends: PluginRegistry[B]) -> B:
    """Return the backend that opens a URL.

    Raises
    ------
    InvalidInput
        No backend has its scheme; the text lists the schemes.
    NotPermitted
        One of another distribution has, but no administrator has allowed it.
    BrokenPlugin
        It cannot be loaded.
    """
    try:
        return backends.create(scheme_of(url), {})
    except NotFound as error:
        known = schemes(backends)
        scheme = url.partition(":")[0]
        raise InvalidInput(f"unknown scheme of a store {scheme!r}; known: {known}") from error


def schemes(backends: PluginRegistry[B]) -> str:
    """Return the schemes of all backends as a list for people to read."""
    return ", ".join(f"{name}:" for name in backends.names())
