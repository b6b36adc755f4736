"""Dictionary with a limited number of entries, for caches and for counters by name."""

from collections import OrderedDict
from typing import TypeVar

K = TypeVar("K")
V = TypeVar("V")


class BoundedDict(OrderedDict[K, V]):
    """Dictionary in the order of the last assignments; beyond its size, an assignment drops the oldest entry.

    A user that reads an entry, too, keeps it with ``move_to_end``.

    Parameters
    ----------
    size : int
        Largest number of entries.
    """

    def __init__(self, size: int) -> None:
        super().__init__()
        self._size = size

    def __setitem__(self, key: K, value: V) -> None:
        """Assign a value; the entry becomes the newest."""
        super().__setitem__(key, value)
        self.move_to_end(key)
        if len(self) > self._size:
            self.popitem(last=False)
