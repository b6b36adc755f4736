"""The one place from which the domain takes time, so that a test can put its own in.

Two kinds of time, never mixed: *stamps* are seconds since the epoch and travel in messages; *monotonic* seconds
measure how long something took and decide when a timer fires.
"""

import time
from collections.abc import Callable

Clock = Callable[[], float]
"""Returns seconds as a float."""

monotonic: Clock = time.perf_counter
epoch: Clock = time.time


class ManualClock:
    """A clock that stands still until it is told to go on.

    Parameters
    ----------
    start : float
        First reading [s].
    """

    def __init__(self, start: float = 0.0) -> None:
        self.now = start

    def __call__(self) -> float:
        """Return the seconds it shows."""
        return self.now

    def advance(self, seconds: float) -> None:
        """Move on by ``seconds``; time never goes back."""
        if seconds < 0:
            raise ValueError(f"a clock cannot go back by {-seconds} s")
        self.now += seconds
