"""Arrivals of the messages of one topic: rate, gaps, bursts, and how late their stamps are."""

import itertools
import statistics
from collections import deque
from typing import NamedTuple

from ppaas.bounded import BoundedDict

WINDOW = 10.0
"""Time for which arrivals are kept [s]."""

MOST = 2000
"""Largest number of arrivals of a topic that are kept."""

MOST_FRAMES = 64
"""Largest number of frames whose last stamps are kept."""

NEWEST = 20
"""Number of arrivals by which the present delay is judged."""

PARTS = 4
"""Number of parts of the time in each of which a delay must grow."""

BURST = 0.1
"""Part of the usual interval within which two messages count as a burst."""


class MessageArrival(NamedTuple):
    """Arrival of a message.

    Parameters
    ----------
    at : float
        Monotonic time [s].
    late : float or None
        Time since its stamp [s]; None if its stamp is zero or it has none.
    stamped : bool
        Whether its type has a stamp.
    """

    at: float
    late: float | None
    stamped: bool


class Arrivals:
    """Arrivals of the messages of one topic in the last `WINDOW` seconds."""

    def __init__(self) -> None:
        self._kept: deque[MessageArrival] = deque(maxlen=MOST)
        self._newest: BoundedDict[str, float] = BoundedDict(MOST_FRAMES)
        self._backwards: deque[float] = deque(maxlen=MOST)

    def note(self, now: float, wall: float, stamp: float | None = None, frame: str = "") -> None:
        """Note a message.

        Parameters
        ----------
        now, wall : float
            Time of arrival: monotonic, and since the epoch [s].
        stamp : float, optional
            Its stamp [s]; None for a type without.
        frame : str
            Frame of the stamp: the stamps of each frame have a separate order.
        """
        self._kept.append(MessageArrival(now, wall - stamp if stamp else None, stamp is not None))
        if stamp:
            if stamp < self._newest.get(frame, stamp):
                self._backwards.append(now)
            self._newest[frame] = stamp

    def recent(self, now: float) -> list[MessageArrival]:
        """Return the arrivals of the last `WINDOW` seconds, and forget earlier ones."""
        for kept in (self._kept, self._backwards):
            while kept and now - _time_of(kept[0]) > WINDOW:
                kept.popleft()
        return list(self._kept)

    def backwards(self) -> int:
        """Return the number of messages of the recent ones that are stamped before the one before."""
        return len(self._backwards)


def _time_of(entry: "MessageArrival | float") -> float:
    return entry.at if isinstance(entry, MessageArrival) else entry


def gap_and_burst(recent: list[MessageArrival], now: float) -> tuple[float | None, float]:
    """Return the longest time without a message [s], and the share of messages that came in a burst."""
    if len(recent) < 2:
        return None, 0.0
    intervals = [later.at - earlier.at for earlier, later in itertools.pairwise(recent)]
    usual = (recent[-1].at - recent[0].at) / len(intervals)
    close = sum(interval < BURST * usual for interval in intervals)
    return max(*intervals, now - recent[-1].at), close / len(intervals)


def lateness(recent: list[MessageArrival]) -> tuple[float | None, float]:
    """Return the median time since the stamps of the newest messages [s], and its steady growth [s].

    Growth is what all parts of the time have in common: a clock that was set once is none.
    """
    late = [arrival.late for arrival in recent if arrival.late is not None]
    if not late:
        return None, 0.0
    return statistics.median(late[-NEWEST:]), _growth(late)


def _growth(late: list[float]) -> float:
    part = len(late) // PARTS
    if part < 3:
        return 0.0
    medians = [statistics.median(late[number * part : (number + 1) * part]) for number in range(PARTS)]
    return max(min(after - before for before, after in itertools.pairwise(medians)) * PARTS, 0.0)


def unstamped(recent: list[MessageArrival]) -> float:
    """Return the share of the messages with a stamp whose stamp is zero."""
    stamped = [arrival for arrival in recent if arrival.stamped]
    return sum(arrival.late is None for arrival in stamped) / len(stamped) if stamped else 0.0
