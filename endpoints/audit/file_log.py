"""Audit log of a data folder: files that a thread writes, so that no caller waits for the disk.

A flood guard folds many similar events into one, so that nobody fills the log and pushes older events out.
"""

import asyncio
import contextlib
import getpass
import logging
import queue
import threading
from collections import OrderedDict
from collections.abc import AsyncIterator, Hashable, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import msgspec

from endpoints.audit.event import AuditEvent, AuditQuery, lost_events
from endpoints.audit.files import FILES, MAX_SIZE, AuditFiles
from engine.processes.private_files import PRIVATE
from ppaas import __version__
from ppaas.clock import Clock, monotonic
from ppaas.errors import InvalidInput, Unavailable

logger = logging.getLogger(__name__)


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
        self._wait_until_stored()
        try:
            return self._files.read(query, before=before, limit=limit)
        except OSError as error:
            raise Unavailable(f"the audit log cannot be read: {error}") from error

    def expire(self, before: float, *, dry_run: bool = False) -> int:
        """Remove the events before a time [s since the epoch], after those that were recorded until now are stored.

        See ``AuditFiles.expire``.

        Raises
        ------
        Unavailable
            The files cannot be read or written.
        """
        self._wait_until_stored()
        try:
            return self._files.expire(before, dry_run=dry_run)
        except OSError as error:
            raise Unavailable(f"the audit log cannot be written: {error}") from error

    def _wait_until_stored(self) -> None:
        """Wait until all events that were recorded until now are stored, or for `FLUSH_TIMEOUT`."""
        stored = threading.Event()
        self._queue.put(stored)
        stored.wait(FLUSH_TIMEOUT)

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
