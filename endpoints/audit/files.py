"""Files of the audit log: lines of JSON, which several processes append one after the other; rotated by size."""

import contextlib
import fcntl
import itertools
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import msgspec

from endpoints.audit.event import AuditEvent, AuditQuery, select
from engine.processes.private_files import PRIVATE

MAX_SIZE = 16 << 20
"""Size at which a file is rotated [bytes]."""

FILES = 8
"""Number of files that are kept, the current one included."""

BLOCK = 1 << 16
"""Number of bytes that are read at once; also the longest line."""

_FLAGS = os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW

_decoder = msgspec.json.Decoder(AuditEvent)


class AuditFiles:
    """Files ``audit.jsonl``, the current one, ``audit.jsonl.1``, the one before, and so on.

    A damaged line is skipped; it affects no other line. Several processes may append: each opens the current file and
    locks it, reads the last number, and rotates the files before it lets go.

    Parameters
    ----------
    path : Path
        Current file; created, readable by this user only.
    max_size : int
        Size at which a file is rotated [bytes].
    files : int
        Number of files that are kept.
    """

    def __init__(self, path: Path, max_size: int = MAX_SIZE, files: int = FILES) -> None:
        self._path = path
        self._max_size = max_size
        self._rotated = [path.with_name(f"{path.name}.{number}") for number in range(1, files)]

    def append(self, events: Sequence[AuditEvent]) -> None:
        """Append events in this order, all or none; they get the next numbers.

        Raises
        ------
        OSError
            They cannot be stored, for example because the disk is full.
        """
        with self._locked(fcntl.LOCK_EX) as file:
            self._append(file, events)

    def read(self, query: AuditQuery, *, before: int | None = None, limit: int = 100) -> list[AuditEvent]:
        """Return events, newest first; raises ``OSError`` if the files cannot be read."""
        with contextlib.ExitStack() as stack:
            with self._locked(fcntl.LOCK_SH) as file:  # no file is rotated meanwhile
                files = [_closed_by(stack, os.dup(file))]
                files += [_closed_by(stack, _open(path)) for path in self._rotated if path.exists()]
            return select(_newest_first(files, query, before), query, before, limit)

    def expire(self, before: float, *, dry_run: bool = False) -> int:
        """Remove the events before a time [s since the epoch], except the last one, after whose number others follow.

        Returns
        -------
        int
            Their number. With ``dry_run`` nothing is removed.

        Raises
        ------
        OSError
            A file cannot be read or written.
        """
        removed = 0
        with self._locked(fcntl.LOCK_EX) as file:
            last = self._last_number(file, os.fstat(file).st_size)
            for path in (self._path, *filter(Path.exists, self._rotated)):
                lines = path.read_bytes().splitlines(keepends=True)
                kept = [line for line in lines if not _is_before(line, before, last)]
                removed += len(lines) - len(kept)
                if not dry_run and len(kept) < len(lines):
                    self._replace(path, kept)
        return removed

    def _replace(self, path: Path, lines: Sequence[bytes]) -> None:
        """Replace a file at once; a process that waits for its lock opens the new one."""
        if not lines and path != self._path:
            path.unlink()
            return
        partial = path.with_name(f"{path.name}.partial")
        times = path.stat()
        file = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC | os.O_NOFOLLOW, PRIVATE)
        try:
            _write(file, b"".join(lines))
        finally:
            os.close(file)
        os.utime(partial, ns=(times.st_atime_ns, times.st_mtime_ns))
        partial.replace(path)

    @contextlib.contextmanager
    def _locked(self, operation: int) -> Iterator[int]:
        """Open and lock the current file; if it was rotated meanwhile, the new one."""
        while True:
            file = os.open(self._path, _FLAGS, PRIVATE)
            try:
                fcntl.flock(file, operation)
                if _is_at(file, self._path):
                    yield file
                    return
            finally:
                fcntl.flock(file, fcntl.LOCK_UN)  # closing is not enough: it may have been duplicated
                os.close(file)

    def _append(self, file: int, events: Sequence[AuditEvent]) -> None:
        state = os.fstat(file)
        number = self._last_number(file, state.st_size)
        numbered = [msgspec.structs.replace(event, number=number + at) for at, event in enumerate(events, 1)]
        lines = b"".join(map(_line, numbered))
        if state.st_size and os.pread(file, 1, state.st_size - 1) != b"\n":
            lines = b"\n" + lines  # the last line is incomplete: its process was killed
        try:
            _write(file, lines)
        except OSError:
            os.ftruncate(file, state.st_size)
            raise
        if state.st_size + len(lines) >= self._max_size:
            self._rotate()

    def _rotate(self) -> None:
        paths = [self._path, *self._rotated]
        for newer, older in reversed(list(itertools.pairwise(paths))):
            if newer.exists():
                newer.replace(older)
        if not self._rotated:
            self._path.unlink()

    def _last_number(self, file: int, size: int) -> int:
        for event in _events(_lines(file, size)):
            return event.number
        with contextlib.ExitStack() as stack:
            for path in filter(Path.exists, self._rotated[:1]):
                previous = _closed_by(stack, _open(path))
                for event in _events(_lines(previous, os.fstat(previous).st_size)):
                    return event.number
        return 0


def _line(event: AuditEvent) -> bytes:
    try:
        line = msgspec.json.encode(event)
    except Exception:  # noqa: BLE001  # one event must not keep the others from being stored
        line = msgspec.json.encode(msgspec.structs.replace(event, user=None, object=None, details={"damaged": True}))
    return line + b"\n"


def _is_before(line: bytes, before: float, last: int) -> bool:
    """Return whether a line is an event before a time and not the last one; damaged lines are kept."""
    return any(event.time < before and event.number != last for event in _events(iter((line,))))


def _open(path: Path) -> int:
    return os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW)


def _closed_by(stack: contextlib.ExitStack, file: int) -> int:
    """Return an open file, which is closed with the stack."""
    stack.callback(os.close, file)
    return file


def _is_at(file: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except FileNotFoundError:
        return False


def _write(file: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(file, view) :]
    os.fdatasync(file)


def _newest_first(files: Iterable[int], query: AuditQuery, before: int | None) -> Iterator[AuditEvent]:
    needles = [
        f'"{name}":'.encode() + msgspec.json.encode(value)
        for name, value in (("user", query.user), ("action", query.action))
        if value is not None
    ]
    for file in files:
        state = os.fstat(file)
        if query.after is not None and state.st_mtime < query.after:
            return  # it was written last before that time, and so were the older files
        end = state.st_size if before is None else _end_before(file, state.st_size, before)
        yield from _events(line for line in _lines(file, end) if all(needle in line for needle in needles))


def _end_before(file: int, size: int, before: int) -> int:
    """Return an offset within the file after all events with numbers smaller than ``before``; by bisection."""
    low, high = 0, size
    while high - low > 4 * BLOCK:
        middle = (low + high) // 2
        event = next(_events(iter(os.pread(file, 2 * BLOCK, middle).split(b"\n"))), None)
        if event is None:
            break
        if event.number < before:
            low = middle
        else:
            high = middle + 2 * BLOCK
    return high


def _lines(file: int, end: int) -> Iterator[bytes]:
    rest = b""
    while end > 0:
        begin = max(0, end - BLOCK)
        rest, *lines = (os.pread(file, end - begin, begin) + rest).split(b"\n")
        yield from reversed(lines)
        if len(rest) > BLOCK:
            rest = b""  # no event is this long: the rest of the line is skipped too, as it is no JSON
        end = begin
    yield rest


def _events(lines: Iterator[bytes]) -> Iterator[AuditEvent]:
    for line in lines:
        try:
            yield _decoder.decode(line)
        except (msgspec.DecodeError, UnicodeDecodeError):
            continue
