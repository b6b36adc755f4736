"""Data folder of a cloud, as endpoints of other hosts use it: the audit log, and the recordings of removed users.

Events of an endpoint of another host wait there until the master has recorded them.
"""

import asyncio
import contextlib
import logging
from collections import deque
from itertools import islice
from typing import Protocol

from endpoints.audit.event import AuditEvent, AuditLog, AuditQuery, lost_events
from endpoints.audit.file_log import MAX_BATCH, MAX_WAITING
from engine.processes.background import Background, repeat
from ppaas.errors import Unavailable
from storage.recordings import RecordingsFolder

logger = logging.getLogger(__name__)


class DataFolderCalls(Protocol):
    """Calls of endpoints that have no access to the data folder."""

    async def record_events(self, events: list[AuditEvent]) -> None:
        """Add events to the audit log."""
        ...

    async def read_events(self, query: AuditQuery, before: int | None, limit: int) -> list[AuditEvent]:
        """Return events of the audit log; see ``AuditLog.read``."""
        ...

    async def remove_recordings(self, user: str, robot: str | None) -> None:
        """Remove the recordings of a robot, or of all robots of a user."""
        ...


class DataFolder:
    """Serves ``DataFolderCalls``.

    Parameters
    ----------
    audit : AuditLog
    recordings : RecordingsFolder, optional
        None if the cloud keeps no recordings.
    """

    def __init__(self, audit: AuditLog, recordings: RecordingsFolder | None) -> None:
        self._audit = audit
        self._recordings = recordings

    async def record_events(self, events: list[AuditEvent]) -> None:
        """Add events to the audit log."""
        for event in events:
            self._audit.record(event)

    async def read_events(self, query: AuditQuery, before: int | None, limit: int) -> list[AuditEvent]:
        """Return events of the audit log."""
        return await asyncio.to_thread(self._audit.read, query, before=before, limit=limit)

    async def remove_recordings(self, user: str, robot: str | None) -> None:
        """Remove the recordings of a robot, or of all robots of a user."""
        if self._recordings is None:
            return
        if robot is None:
            await asyncio.to_thread(self._recordings.remove_user, user)
        else:
            await asyncio.to_thread(self._recordings.remove_robot, user, robot)


PERIOD = 0.5
"""Interval of transfers to the master [s]."""

READ_TIMEOUT, CLOSE_TIMEOUT = 10.0, 2.0
"""Time limits of a query, and to send the last events at the end [s]."""


class FarAuditLog:
    """Audit log in a data folder; implements ``AuditLog``.

    An event may be recorded twice if the master dies while it answers.

    Parameters
    ----------
    folder : DataFolderCalls
    """

    def __init__(self, folder: DataFolderCalls) -> None:
        self._folder = folder
        self._waiting: deque[AuditEvent] = deque()
        self._lost = 0
        self._sending = asyncio.Lock()
        self._loop = asyncio.get_running_loop()
        self._background = Background()
        self._background.run(repeat(self._send, PERIOD))
        self.fault: str | None = None

    def record(self, event: AuditEvent) -> None:
        """Add an event."""
        if len(self._waiting) < MAX_WAITING:
            self._waiting.append(event)
        else:
            self._lost += 1

    async def _send(self) -> None:
        async with self._sending:
            await self._send_all()

    async def _send_all(self) -> None:
        if self._lost and len(self._waiting) < MAX_WAITING:
            lost, self._lost = self._lost, 0
            self._waiting.append(lost_events(lost))
        while self._waiting:
            batch = list(islice(self._waiting, MAX_BATCH))
            try:
                await self._folder.record_events(batch)
            except Unavailable as error:
                self.fault = f"{len(self._waiting)} events wait for the master: {error}"
                return
            for _ in batch:
                self._waiting.popleft()
        self.fault = None

    def read(self, query: AuditQuery, *, before: int | None = None, limit: int = 100) -> list[AuditEvent]:
        """Return events, newest first; blocks, and must be called from a thread.

        Raises
        ------
        Unavailable
            The master does not answer.
        """
        asked = asyncio.run_coroutine_threadsafe(self._read(query, before, limit), self._loop)
        try:
            return asked.result(READ_TIMEOUT)
        except TimeoutError as error:
            asked.cancel()
            raise Unavailable("the master, which has the audit log, does not answer; try again") from error

    async def _read(self, query: AuditQuery, before: int | None, limit: int) -> list[AuditEvent]:
        await self._send()
        return await self._folder.read_events(query, before, limit)

    async def close(self) -> None:
        """Send the last events, if the master answers."""
        await self._background.cancel()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(CLOSE_TIMEOUT):
                await self._send()
        if self._waiting:
            logger.error("%d events of the audit log are lost: no master took them", len(self._waiting))
