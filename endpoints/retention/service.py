"""Retention in the process of the master: removes what has expired once a day, and when an administrator asks."""

import asyncio
import logging
import math
from collections.abc import Mapping

from endpoints.audit.event import AuditEvent, AuditLog, Outcome
from endpoints.retention.calls import ExpiredData, RetentionView
from endpoints.retention.kinds import DAY, DEFAULT_DAYS, KINDS, Expiry, Kept
from engine.processes.background import repeat
from ppaas.clock import Clock, epoch
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)

GIGABYTE = 1e9
"""Bytes of a GB."""

DELAY = 60.0
"""Time from the start until expired data are removed first [s]: robots that come back are served before."""


class Retention:
    """Removes expired data; implements ``RetentionCalls``.

    Parameters
    ----------
    kept : Kept
    audit : AuditLog
        Where removals are recorded.
    days : mapping of str to float
        Settings, by kind [days].
    clock : callable
        Returns the time [s since the epoch].
    gigabytes : mapping of str to float, optional
        Sizes beyond which the oldest data are removed, by kind [GB].
    """

    def __init__(
        self,
        kept: Kept,
        audit: AuditLog,
        days: Mapping[str, float],
        clock: Clock = epoch,
        *,
        gigabytes: Mapping[str, float] | None = None,
    ) -> None:
        self._kept = kept
        self._audit = audit
        self.change(days, gigabytes or {})
        self._clock = clock
        self._last: dict[str, tuple[float, int | None]] = {}
        self._turn = asyncio.Lock()

    def change(self, days: Mapping[str, float], gigabytes: Mapping[str, float]) -> None:
        """Keep data for other times [days], and up to other sizes [GB], from the next removal on."""
        self._days = {**DEFAULT_DAYS, **days}
        self._gigabytes = dict(gigabytes)

    def seconds(self, kind: str) -> float:
        """Return for how long a kind of data is kept [s]; infinity if it is kept however old it is."""
        return self._days.get(kind, math.inf) * DAY

    async def run(self) -> None:
        """Remove expired data every day until cancelled."""
        await asyncio.sleep(DELAY)
        await repeat(self._daily, DAY)

    async def views(self) -> list[RetentionView]:
        """Return for how long each kind of data is kept."""
        return [self._view(name, kind.text) for name, kind in KINDS.items()]

    def _view(self, name: str, text: str) -> RetentionView:
        last_run, removed = self._last.get(name, (None, None))
        return RetentionView(name, text, self._days.get(name), last_run, removed, self._gigabytes.get(name))

    async def expire(self, dry_run: bool) -> list[ExpiredData]:
        """Remove what has expired, or only count it; return what it is."""
        async with self._turn:
            limited = self._days.keys() | self._gigabytes.keys()
            return [await self._expire(name, dry_run=dry_run) for name in KINDS if name in limited]

    async def _daily(self) -> None:
        await self.expire(dry_run=False)

    async def _expire(self, name: str, *, dry_run: bool) -> ExpiredData:
        now = self._clock()
        before = now - self._days[name] * DAY if name in self._days else 0.0
        expiry = Expiry(before, now, dry_run, self._gigabytes.get(name, math.inf) * GIGABYTE)
        try:
            found = ExpiredData(name, expiry.before, await asyncio.to_thread(KINDS[name].expire, self._kept, expiry))
        except (PPaaSError, OSError) as error:
            logger.warning("expired %s are not removed: %s", name, error)
            found = ExpiredData(name, expiry.before, fault=str(error))
        if not dry_run:
            self._last[name] = now, None if found.fault else found.expired
            self._record(found)
        return found

    def _record(self, found: ExpiredData) -> None:
        if not found.expired and not found.fault:
            return
        if found.expired:
            logger.info("removed %d expired %s", found.expired, found.kind)
        limits = {"days": self._days.get(found.kind), "gigabytes": self._gigabytes.get(found.kind)}
        details = {name: limit for name, limit in limits.items() if limit is not None} | {"removed": found.expired}
        outcome: Outcome = "failed" if found.fault else "ok"
        self._audit.record(
            AuditEvent(action="expire_data", outcome=outcome, object=f"retention/{found.kind}", details=details)
        )
