"""Data folder of a cloud, as endpoints of other hosts use it: the audit log, and the recordings of removed users."""

import asyncio
from typing import Protocol

from endpoints.audit.event import AuditEvent, AuditLog, AuditQuery
from storage.recordings.folder import RecordingsFolder


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
