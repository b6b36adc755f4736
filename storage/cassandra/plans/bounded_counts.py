"""Counts of recent keys, each up to a limit."""

from collections import OrderedDict
from typing import Generic, TypeVar

Key = TypeVar("Key")


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
