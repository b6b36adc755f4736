"""Audit events, and the interface of logs of them."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import msgspec

from ppaas.clock import epoch

Outcome = Literal["ok", "refused", "failed"]

MAX_IN_MEMORY = 10_000
"""Largest number of events of a log in memory."""


class AuditEvent(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One event. It never contains a password or the text of a token.

    Parameters
    ----------
    number : int
        Number of the event, assigned by the log; later events have larger numbers.
    time : float
        Time [s since the epoch].
    action : str
        Id of the REST operation, as ``remove_map``; or ``connect``, ``disconnect``, ``start_cloud``, ``stop_cloud``,
        ``make_ticket``, ``hand_over``, ``propose_change``, ``lose_events``, ``disable_webhook``, ``expire_data``,
        ``reload_settings``.
    outcome : {"ok", "refused", "failed"}
        Whether it was done, refused to the caller, or failed by a fault of the cloud.
    user : str, optional
        User who did it; None if it is unknown.
    token : str, optional
        First characters of the id of the user's token.
    address : str
        Address of the client; empty for this host.
    object : str, optional
        Object of the action, as ``maps/office``.
    status : int, optional
        HTTP status.
    reason : str, optional
        Slug of the problem.
    details : dict
        Changes that were made, without secrets.
    repeats : int
        Number of similar events of the last minute that are not listed, because there were too many.
    """

    number: int = 0
    time: float = msgspec.field(default_factory=epoch)
    action: str
    outcome: Outcome = "ok"
    user: str | None = None
    token: str | None = None
    address: str = ""
    object: str | None = None
    status: int | None = None
    reason: str | None = None
    details: dict[str, Any] = {}
    repeats: int = 0


def lost_events(count: int) -> AuditEvent:
    """Return the event that a number of others could not be recorded."""
    return AuditEvent(action="lose_events", outcome="failed", details={"events": count})


@dataclass(frozen=True, slots=True)
class AuditQuery:
    """Query of events: at or after a time [s since the epoch], of a user, of an action, with an outcome, of an object.

    Events of an object include those of its parts: of ``robots/tb1`` also ``robots/tb1/goals/7``.
    """

    after: float | None = None
    user: str | None = None
    action: str | None = None
    outcome: Outcome | None = None
    object: str | None = None

    def matches(self, event: AuditEvent) -> bool:
        """Return whether an event is sought."""
        return (
            (self.after is None or event.time >= self.after)
            and self.user in (None, event.user)
            and self.action in (None, event.action)
            and self.outcome in (None, event.outcome)
            and (self.object is None or _is_part(event.object, self.object))
        )


def _is_part(name: str | None, whole: str) -> bool:
    return name is not None and (name == whole or name.startswith(f"{whole}/"))


class AuditLog(Protocol):
    """Append-only log of events."""

    @property
    def fault(self) -> str | None:
        """Fault that keeps events from being stored now; None if there is none."""
        ...

    def record(self, event: AuditEvent) -> None:
        """Add an event; neither blocks nor raises."""
        ...

    def read(self, query: AuditQuery, *, before: int | None = None, limit: int = 100) -> list[AuditEvent]:
        """Return events, newest first; blocks.

        Parameters
        ----------
        query : AuditQuery
            Events that are sought.
        before : int, optional
            Return only events with smaller numbers.
        limit : int
            Maximum number of events.
        """
        ...


class MemoryAuditLog:
    """Log of the last events in memory, for tests."""

    fault: str | None = None

    def __init__(self) -> None:
        self._events: deque[AuditEvent] = deque(maxlen=MAX_IN_MEMORY)
        self._number = 0

    def record(self, event: AuditEvent) -> None:
        """Add an event."""
        self._number += 1
        self._events.append(msgspec.structs.replace(event, number=self._number))

    def read(self, query: AuditQuery, *, before: int | None = None, limit: int = 100) -> list[AuditEvent]:
        """Return events, newest first."""
        return select(reversed(self._events), query, before, limit)

    def expire(self, before: float, *, dry_run: bool = False) -> int:
        """Remove the events before a time [s since the epoch], except the last one; return their number."""
        old = [event for event in self._events if event.time < before and event.number < self._number]
        for event in old if not dry_run else ():
            self._events.remove(event)
        return len(old)


def select(events: Iterator[AuditEvent], query: AuditQuery, before: int | None, limit: int) -> list[AuditEvent]:
    """Return the first ``limit`` events that a query seeks and whose numbers are smaller than ``before``."""
    found: list[AuditEvent] = []
    for event in events:
        if (before is None or event.number < before) and query.matches(event):
            found.append(event)
            if len(found) >= limit:
                break
    return found
