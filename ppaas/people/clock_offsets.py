"""Offsets of the clocks of robots and their devices: stamps against the times at which messages arrive.

Messages arrive late, never early. So the least difference between arrival and stamp over some seconds is the offset of
the clock, and a little delay; as of the clock filter of NTP (RFC 5905, section 10).
"""

import math

WINDOW = 5.0
"""Usual window of `ClockOffset` [s]."""

TOLERANCE = 0.35
"""Largest offset that may be a delay, of the network or of a detector; larger ones are corrected [s]."""

LATEST = 1.0
"""Delay beyond the delay of a device's other messages from which a measurement is out of date [s]."""


class ClockOffset:
    """Offset of one clock.

    Parameters
    ----------
    window : float
        Time over which the least difference is taken; twice as long at most [s].
    """

    def __init__(self, window: float = WINDOW) -> None:
        self._window = window
        self._began = -math.inf
        self._least = self._before = math.inf

    @property
    def seconds(self) -> float:
        """Time to add to stamps of the device to get times of arrival without delay [s]; 0 before the first stamp."""
        least = min(self._least, self._before)
        return least if math.isfinite(least) else 0.0

    def note(self, stamp: float, now: float) -> float:
        """Note the stamp of a message that arrives now; return its delay beyond the offset [s]."""
        if not 0.0 <= now - self._began < self._window:
            # After a break, what was measured before it shows nothing.
            recent = 0.0 <= now - self._began < 2.0 * self._window
            self._before, self._least, self._began = self._least if recent else math.inf, math.inf, now
        self._least = min(self._least, now - stamp)
        return now - stamp - self.seconds


def corrected(stamp: float, offset: float) -> float:
    """Return a stamp [s], corrected by an offset that is too large to be a delay."""
    return stamp + offset if abs(offset) > TOLERANCE else stamp
