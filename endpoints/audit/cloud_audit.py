"""Audit log of a running cloud: records its start and its stop, and makes of tickets in its data folder."""

import asyncio
import getpass
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.metadata import version
from pathlib import Path

from endpoints.audit.event import AuditEvent
from endpoints.audit.file_log import FileAuditLog

AUDIT = "audit.jsonl"
"""File in the data folder with the latest events."""


@asynccontextmanager
async def cloud_audit(data: Path) -> AsyncIterator[FileAuditLog]:
    """Open the audit log in a data folder, from the start of a cloud to its stop; raises as ``FileAuditLog`` does."""
    log = await asyncio.to_thread(FileAuditLog, data / AUDIT)
    log.record(AuditEvent(action="start_cloud", user=host_user(), details={"version": version("ppaas")}))
    try:
        yield log
    finally:
        log.record(AuditEvent(action="stop_cloud"))
        await asyncio.to_thread(log.close)


def host_user() -> str:
    """Return the user of this host, marked as such: it is no user of the cloud."""
    try:
        return f"{getpass.getuser()} (host)"
    except (KeyError, OSError):  # a user id without a name, as in containers
        return "(host)"
