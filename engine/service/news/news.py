"""News between the processes of a cloud: what one of them changed in the stores, so that others drop it from caches."""

import logging
from collections.abc import Callable
from typing import Literal

from ppaas.listener_faults import ListenerFaults

logger = logging.getLogger(__name__)

NewsKind = Literal["map", "robot", "user"]
"""Kind of the record that was changed."""

Hear = Callable[[NewsKind, str], None]
"""Called with the kind and the key of a record that was changed."""


class News:
    """Passes news on to those who asked for them."""

    def __init__(self) -> None:
        self._listeners: list[Hear] = []
        self._faults = ListenerFaults(logger)

    def listen(self, hear: Hear) -> None:
        """Pass news on to a function, too."""
        self._listeners.append(hear)

    def leave(self, hear: Hear) -> None:
        """Stop passing news on to a function."""
        if hear in self._listeners:
            self._listeners.remove(hear)

    def tell(self, kind: NewsKind, key: str, *, source: Hear | None = None) -> None:
        """Pass a change on to all listeners but its source."""
        for hear in tuple(self._listeners):
            if hear != source:
                self._faults.call(f"a listener to news of a {kind}", hear, kind, key)
