"""Clocks of the domain, and a clock that tests set by hand.

The domain takes time from here only. It never mixes two kinds of time: *stamps* are seconds since the epoch, for
messages; *monotonic* seconds measure durations and decide when a timer fires. ``uptime`` is for what must not outlast
a suspended computer.
"""

import time
from collections.abc import Callable

Clock = Callable[[], float]
"""Returns seconds as a float."""

monotonic: Clock = time.perf_counter
epoch: Clock = time.time


def uptime() -> float:
    """Return the time since the computer was started [s]; unlike ``monotonic``, it advances while it is suspended."""
    return time.clock_gettime(time.CLOCK_BOOTTIME)


class ManualClock:
    """Clock that moves only when ``advance`` is called.

    Parameters
    ----------
    start : float
        Initial time [s].
    """

    def __init__(self, start: float = 0.0) -> None:
        self.now = start

    def __call__(self) -> float:
        """Return the current time [s]."""
        return self.now

    def advance(self, seconds: float) -> None:
        """Move the clock forward.

        Raises
        ------
        ValueError
            ``seconds`` is negative.
        """
        if seconds < 0:
            raise ValueError(f"a clock cannot be set back by {-seconds} s")
        self.now += seconds
