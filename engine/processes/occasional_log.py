"""Log of a fault that repeats: its first line at once, then one line per period with the number of repetitions."""

import logging

from ppaas.clock import Clock, monotonic

PERIOD = 600.0
"""Time between two lines about the same fault [s]."""


class OccasionalLog:
    """Warnings about one kind of fault, which may repeat several times a second.

    Parameters
    ----------
    logger : Logger
    period : float
        Time between two lines [s].
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, logger: logging.Logger, period: float = PERIOD, clock: Clock = monotonic) -> None:
        self._logger = logger
        self._period = period
        self._clock = clock
        self._next = float("-inf")
        self._unlogged = 0

    def warning(self, text: str, *arguments: object) -> None:
        """Log a fault, unless one was logged within the period."""
        if self._clock() < self._next:
            self._unlogged += 1
            return
        repeated = f" ({self._unlogged} more like this since the last line)" if self._unlogged else ""
        self._logger.warning(text + repeated, *arguments)
        self._next, self._unlogged = self._clock() + self._period, 0

    def is_over(self, text: str) -> None:
        """Log that the fault is over, if one was logged; the next fault is logged at once."""
        if self._next > float("-inf"):
            self._logger.info(text)
            self._next, self._unlogged = float("-inf"), 0
