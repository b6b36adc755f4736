"""When keys were written last, as a process knows it of those of late."""

import math
import threading
from collections import OrderedDict
from collections.abc import Iterable, Mapping
from typing import Generic, TypeVar

Key = TypeVar("Key")


class LastWritten(Generic[Key]):
    """When keys were written last [s]; safe to use from several threads.

    Parameters
    ----------
    most : int
        How many are remembered; those that were noted first are forgotten first.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._lock = threading.Lock()
        self._when: OrderedDict[Key, float] = OrderedDict()

    def late(self, keys: Iterable[Key], since: float) -> list[Key]:
        """Return those that were not written since some time, as far as is known; each once."""
        with self._lock:
            return [key for key in dict.fromkeys(keys) if self._when.get(key, -math.inf) < since]

    def note(self, written: Mapping[Key, float]) -> None:
        """Remember when keys were written."""
        with self._lock:
            for key, when in written.items():
                self._when[key] = when
                self._when.move_to_end(key)
            while len(self._when) > self._most:
                self._when.popitem(last=False)
