"""Cache of the times at which this process last wrote keys."""

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
