"""How many there are of each of many keys, up to a limit, as a process knows it of those of late."""

from collections import OrderedDict
from typing import Generic, TypeVar

Key = TypeVar("Key")


class BoundedCounts(Generic[Key]):
    """Counts by key; whoever uses it from several threads has a lock.

    Parameters
    ----------
    limit : int
        Of each key.
    most : int
        How many keys are remembered; those that were counted first are forgotten first.
    """

    def __init__(self, limit: int, most: int) -> None:
        self._limit = limit
        self._most = most
        self._counts: OrderedDict[Key, int] = OrderedDict()

    def take(self, key: Key) -> bool:
        """Tell whether there is room for one more of a key, and count it."""
        if self.is_full(key):
            return False
        self._counts[key] = self._counts.get(key, 0) + 1
        self._counts.move_to_end(key)
        if len(self._counts) > self._most:
            self._counts.popitem(last=False)
        return True

    def is_full(self, key: Key) -> bool:
        """Tell whether there is no room for one more of a key."""
        return self._counts.get(key, 0) >= self._limit

    def forget(self, key: Key) -> None:
        """Count a key from nothing again."""
        self._counts.pop(key, None)

    def clear(self) -> None:
        """Count all from nothing again."""
        self._counts.clear()
