"""Caches of keys in the memory of this process: when it last wrote each, and counts of recent ones."""

import math
import threading
from collections import OrderedDict
from collections.abc import Iterable, Mapping
from typing import Generic, TypeVar

Key = TypeVar("Key")


class LastWritten(Generic[Key]):
    """Times of the last write by key [s]. Thread-safe.

    Parameters
    ----------
    size : int
        Largest number of keys; the least recently written are forgotten first.
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self._lock = threading.Lock()
        self._times: OrderedDict[Key, float] = OrderedDict()

    def older(self, keys: Iterable[Key], since: float) -> list[Key]:
        """Return the keys, each once, that are not known to have been written since a time [s]."""
        with self._lock:
            return [key for key in dict.fromkeys(keys) if self._times.get(key, -math.inf) < since]

    def record(self, written: Mapping[Key, float]) -> None:
        """Record the times at which keys were written [s]."""
        with self._lock:
            for key, time in written.items():
                self._times[key] = time
                self._times.move_to_end(key)
            while len(self._times) > self._size:
                self._times.popitem(last=False)


class BoundedCounts(Generic[Key]):
    """Counts by key. Not thread-safe.

    Parameters
    ----------
    limit : int
        Largest count of a key.
    size : int
        Largest number of keys; the least recently counted are forgotten first.
    """

    def __init__(self, limit: int, size: int) -> None:
        self._limit = limit
        self._size = size
        self._counts: OrderedDict[Key, int] = OrderedDict()

    def increase(self, key: Key) -> bool:
        """Count a key; return False, without counting it, if its count has reached the limit."""
        if self.is_full(key):
            return False
        self._counts[key] = self._counts.get(key, 0) + 1
        self._counts.move_to_end(key)
        if len(self._counts) > self._size:
            self._counts.popitem(last=False)
        return True

    def is_full(self, key: Key) -> bool:
        """Return whether the count of a key has reached the limit."""
        return self._counts.get(key, 0) >= self._limit

    def forget(self, key: Key) -> None:
        """Reset the count of a key."""
        self._counts.pop(key, None)

    def clear(self) -> None:
        """Reset all counts."""
        self._counts.clear()
