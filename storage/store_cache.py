"""Cache of what was read from a store, used for longer while the store is unreachable."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from ppaas.bounded import BoundedDict
from ppaas.errors import Unavailable

V = TypeVar("V")

SIZE = 4096
"""Largest number of entries; the least recently used is evicted first."""

LIFETIME = 30.0
"""Time for which an entry is valid [s]; changes by another process are seen after this time at the latest."""

PATIENCE = 24 * 3600.0
"""Time for which an entry is used while the store is unreachable [s]."""

RETRY = 5.0
"""Time after which an unreachable store is queried again for the same key [s]; a query may take as long to fail."""


@dataclass(frozen=True, slots=True)
class _Cached(Generic[V]):
    value: V
    until: float
    last: float


class StoreCache(Generic[V]):
    """Recently read values by key; for use on one event loop.

    Parameters
    ----------
    size : int
        Largest number of entries.
    lifetime : float
        Time for which an entry is valid [s].
    patience : float
        Time for which an entry is used while the store is unreachable [s].

    Attributes
    ----------
    announce : callable
        Called with each key whose value this process has changed, so that caches of other processes drop it.
    """

    def __init__(self, size: int = SIZE, lifetime: float = LIFETIME, patience: float = PATIENCE) -> None:
        self._entries: BoundedDict[str, _Cached[V]] = BoundedDict(size)
        self._lifetime = lifetime
        self._patience = patience
        self._forgotten = 0
        self.announce: Callable[[str], None] = lambda _: None

    async def read(self, key: str, now: float, load: Callable[[], Awaitable[tuple[V, float]]]) -> V:
        """Return a value from the cache, else from the store; the last known one while the store is unreachable.

        Parameters
        ----------
        key : str
        now : float
            Time [s].
        load : callable
            Reads the value from the store, and returns it with the time at which it expires [s]. Its errors are raised.

        Raises
        ------
        Unavailable
            The store is unreachable, and the value was not read within ``patience``.
        """
        known = self._entries.get(key)
        if known is not None and now < known.until:
            self._entries.move_to_end(key)
            return known.value
        forgotten = self._forgotten
        try:
            value, expires = await load()
        except Unavailable:
            known = self._entries.get(key)
            if known is None or now >= known.last:
                raise
            self._entries[key] = replace(known, until=min(now + RETRY, known.last))
            return known.value
        if self._forgotten == forgotten:  # otherwise the value may have changed meanwhile
            self._entries[key] = _Cached(value, min(now + self._lifetime, expires), min(now + self._patience, expires))
        return value

    def forget(self, *keys: str) -> None:
        """Drop the values of these keys, because this process changed or removed them; announce it to other processes.

        Values that are being read now are dropped, too.
        """
        self.drop(*keys)
        for key in keys:
            self.announce(key)

    def drop(self, *keys: str) -> None:
        """Drop the values of these keys, because another process changed or removed them."""
        self._forgotten += 1
        for key in keys:
            self._entries.pop(key, None)

    def forget_where(self, dropped: Callable[[V], bool]) -> None:
        """Drop the values for which a function returns true; other processes are not told."""
        self.drop(*[key for key, entry in self._entries.items() if dropped(entry.value)])

    def drop_all(self) -> None:
        """Drop all values, as news of other processes may have been missed."""
        self.drop(*tuple(self._entries))
