"""Flood guard: folds many similar events into one, so that nobody fills the audit log and pushes older events out."""

from collections import OrderedDict
from collections.abc import Hashable, Iterator
from dataclasses import dataclass

import msgspec

from endpoints.audit.event import AuditEvent
from ppaas.clock import Clock, monotonic

WINDOW = 60.0
"""Time for which similar events are counted [s]."""

PER_KEY = 20
"""Largest number of similar events of a user, or of unknown callers at an address, in a window."""

OF_STRANGERS = 120
"""Largest number of similar events of all unknown callers in a window."""

MAX_WINDOWS = 10_000
"""Largest number of windows; the oldest ends first."""


@dataclass(slots=True)
class _Window:
    began: float
    allowed: int
    last: AuditEvent
    count: int = 0


class FloodGuard:
    """Passes events on; of similar ones beyond a number per minute, only the last, with their number.

    Events are similar if user, action, outcome and reason are the same, and also the object if the action was
    performed. Unknown callers count by their address instead of their user, and all together. Each process counts those
    that it records itself.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._windows: OrderedDict[Hashable, _Window] = OrderedDict()

    def admit(self, event: AuditEvent) -> list[AuditEvent]:
        """Return the events to store now that this one has happened."""
        stored = list(self.ended())
        for key, allowed in _keys(event):
            window = self._windows.setdefault(key, _Window(self._clock(), allowed, event))
            window.count += 1
            if window.count > window.allowed:
                window.last = event
                break
        else:
            stored.append(event)
        while len(self._windows) > MAX_WINDOWS:
            stored += _folded(self._windows.popitem(last=False)[1])
        return stored

    def ended(self, *, all_windows: bool = False) -> Iterator[AuditEvent]:
        """Yield the folded events of windows that have ended, or of all windows."""
        now = self._clock()
        while self._windows:
            window = next(iter(self._windows.values()))
            if not all_windows and now - window.began < WINDOW:
                return
            self._windows.popitem(last=False)
            yield from _folded(window)


def _keys(event: AuditEvent) -> list[tuple[Hashable, int]]:
    """Return the keys of the windows of an event, and the numbers of events that these allow."""
    what = event.action, event.outcome, event.reason
    if event.token is None and event.address:
        return [(("address", event.address, *what), PER_KEY), (("all", *what), OF_STRANGERS)]
    target = event.object if event.outcome == "ok" else None
    return [(("user", event.user, target, *what), PER_KEY)]


def _folded(window: _Window) -> list[AuditEvent]:
    excess = window.count - window.allowed
    return [msgspec.structs.replace(window.last, repeats=excess)] if excess > 0 else []
