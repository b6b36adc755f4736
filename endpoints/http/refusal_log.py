"""Log of what clients did wrong: one warning each, and a few per second for one address."""

import logging

from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic

PER_SECOND = 3
"""Largest number of warnings about one address in a second."""

MAX_ADDRESSES = 1024
"""Number of addresses that are remembered."""

MAX_TEXT = 500
"""Largest length of a warning, which may quote the client [characters]."""


class RefusalLog:
    """Warnings about clients, limited per address, so that nobody fills the log.

    Parameters
    ----------
    logger : Logger
        Logger of the module that refuses.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, logger: logging.Logger, clock: Clock = monotonic) -> None:
        self._logger = logger
        self._clock = clock
        self._seen: BoundedDict[str, tuple[float, int]] = BoundedDict(MAX_ADDRESSES)

    def add(self, address: str, text: str) -> None:
        """Log a warning about a client at this address, unless there were `PER_SECOND` within the last second."""
        now = self._clock()
        began, count = self._seen.get(address, (now, 0))
        if now - began >= 1.0:
            if count > PER_SECOND:
                self._logger.warning("%s: %d more warnings like these were not logged", address, count - PER_SECOND)
            began, count = now, 0
        self._seen[address] = (began, count + 1)
        if count < PER_SECOND:
            self._logger.warning("%s: %s", address, text[:MAX_TEXT].translate(_CONTROL))


_CONTROL = dict.fromkeys((*range(32), 127), " ")
"""Control characters, a new line among them: text of a client must not forge a line of the log."""
