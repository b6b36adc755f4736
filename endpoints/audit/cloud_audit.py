"""Audit log of a data folder: of the processes of a cloud, and of commands on its host."""

import asyncio
import getpass
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import msgspec

from endpoints.audit.event import AuditEvent
from endpoints.audit.file_log import FileAuditLog
from endpoints.audit.files import AuditFiles
from ppaas import __version__

logger = logging.getLogger(__name__)

AUDIT = "audit.jsonl"
"""File in the data folder with the latest events."""


@asynccontextmanager
async def cloud_audit(data: Path, *, is_cloud: bool = True) -> AsyncIterator[FileAuditLog]:
    """Open the audit log in a data folder; raises as ``FileAuditLog`` does.

    Parameters
    ----------
    data : Path
        Data folder.
    is_cloud : bool
        Whether this process is the cloud, whose start and stop are recorded, and not one of several endpoints of it.
    """
    log = await asyncio.to_thread(FileAuditLog, data / AUDIT)
    if is_cloud:
        log.record(AuditEvent(action="start_cloud", user=host_user(), details={"version": __version__}))
    try:
        yield log
    finally:
        if is_cloud:
            log.record(AuditEvent(action="stop_cloud"))
        await asyncio.to_thread(log.close)


def record_on_host(data: Path, event: AuditEvent) -> None:
    """Record what a command of the host did in a data folder; log an error if that fails. It blocks."""
    try:
        AuditFiles(data / AUDIT).append([msgspec.structs.replace(event, user=host_user())])
    except OSError as error:
        logger.error("the audit log in %s cannot be written: %s", data, error.strerror or error)


def host_user() -> str:
    """Return the user of this host, marked as such: it is no user of the cloud."""
    try:
        return f"{getpass.getuser()} (host)"
    except (KeyError, OSError):  # a user id without a name, as in containers
        return "(host)"
