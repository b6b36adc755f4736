"""Audit log in files, which a thread writes, so that no caller waits for the disk."""

import contextlib
import logging
import queue
import threading
from pathlib import Path

from endpoints.audit.event import AuditEvent, AuditQuery, lost_events
from endpoints.audit.files import FILES, MAX_SIZE, AuditFiles
from endpoints.audit.flood_guard import FloodGuard
from engine.processes.private_files import PRIVATE
from ppaas.clock import monotonic
from ppaas.errors import InvalidInput, Unavailable

logger = logging.getLogger(__name__)

PERIOD = 1.0
"""Interval of attempts to store events while they cannot be stored [s]."""

MAX_WAITING = 50_000
"""Largest number of events that wait to be stored; later ones are counted and dropped."""

MAX_BATCH = 1000
"""Largest number of events that are appended at once."""

FLUSH_TIMEOUT = 2.0
"""Time for which a reader waits until the events so far are stored [s]."""

CLOSE_TIMEOUT = 5.0
"""Time limit to store the last events at the end [s]."""


class FileAuditLog:
    """Append-only log of events in the files of a data folder, which several processes may have open.

    Events that cannot be stored, because the disk is full for example, wait in memory and are stored when they can be.

    Parameters
    ----------
    path : Path
        Current file.
    max_size : int
        Size at which a file is rotated [bytes].
    files : int
        Number of files that are kept.
    period : float
        Interval of attempts to store events while they cannot be stored [s].

    Raises
    ------
    InvalidInput
        The file cannot be created or written.
    """

    def __init__(self, path: Path, *, max_size: int = MAX_SIZE, files: int = FILES, period: float = PERIOD) -> None:
        self._path = path
        self._files = AuditFiles(path, max_size, files)
        self._period = period
        self._guard = FloodGuard()
        self._queue: queue.SimpleQueue[AuditEvent | threading.Event | None] = queue.SimpleQueue()
        self._unstored: list[AuditEvent] = []
        self._lost = 0
        self._reported_lost = 0
        self._failed_at: float | None = None
        self.fault: str | None = None
        try:
            self._files.append([])
            path.chmod(PRIVATE)
        except OSError as error:
            raise InvalidInput(f"cannot write the audit log: {error}; make {path} a file of this user") from error
        self._thread = threading.Thread(target=self._run, name="audit log", daemon=True)
        self._thread.start()

    def record(self, event: AuditEvent) -> None:
        """Add an event; neither blocks nor raises."""
        if self._queue.qsize() + len(self._unstored) < MAX_WAITING:
            self._queue.put(event)
        else:
            self._lost += 1

    def read(self, query: AuditQuery, *, before: int | None = None, limit: int = 100) -> list[AuditEvent]:
        """Return events, newest first, after those that were recorded until now are stored.

        Raises
        ------
        Unavailable
            The files cannot be read.
        """
        stored = threading.Event()
        self._queue.put(stored)
        stored.wait(FLUSH_TIMEOUT)
        try:
            return self._files.read(query, before=before, limit=limit)
        except OSError as error:
            raise Unavailable(f"the audit log cannot be read: {error}") from error

    def close(self) -> None:
        """Store the last events, and end the thread."""
        self._queue.put(None)
        self._thread.join(CLOSE_TIMEOUT)

    # -- thread --------------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        closed = False
        while not closed:
            readers, closed = self._collect()
            self._unstored += self._guard.ended(all_windows=closed)
            self._store(closed=closed)
            for reader in readers:
                reader.set()

    def _collect(self) -> tuple[list[threading.Event], bool]:
        """Wait for events and take those that wait; return waiting readers, and whether the log is closed."""
        readers: list[threading.Event] = []
        with contextlib.suppress(queue.Empty):
            item = self._queue.get(timeout=self._period)
            while item is not None:
                if isinstance(item, AuditEvent):
                    self._unstored += self._guard.admit(item)
                else:
                    readers.append(item)
                if len(self._unstored) >= MAX_BATCH:
                    break
                item = self._queue.get_nowait()
            return readers, item is None
        return readers, False

    def _store(self, *, closed: bool) -> None:
        lost = self._lost
        if lost > self._reported_lost and len(self._unstored) < MAX_WAITING:
            self._unstored.append(lost_events(lost - self._reported_lost))
            self._reported_lost = lost
        retry = self._failed_at is None or closed or monotonic() - self._failed_at >= self._period
        if not self._unstored or not retry:
            return
        try:
            self._files.append(self._unstored)
        except OSError as error:
            self._failed(error)
            return
        self._unstored.clear()
        self._failed_at = None
        if self.fault is not None:
            self.fault = None
            logger.info("the audit log %s is written again", self._path)

    def _failed(self, error: OSError) -> None:
        self._failed_at = monotonic()
        fault = f"the audit log {self._path} cannot be written: {error.strerror or error}; free space on its disk"
        if fault != self.fault:
            logger.error("%s. Up to %d events wait in memory", fault, MAX_WAITING)
        self.fault = fault
