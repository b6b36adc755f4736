"""Exclusive ownership of a folder or file by one process, until the process exits or is killed."""

import fcntl
import logging
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from engine.processes.private_files import PRIVATE
from ppaas.clock import epoch
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, Unavailable

logger = logging.getLogger(__name__)

LOCK = "cloud.lock"
"""Name of the lock file in a data folder."""


class Owner(msgspec.Struct, frozen=True):
    """The owner, as the lock file describes it: host, process id, and start [s since the epoch]."""

    host: str
    pid: int
    since: float

    def __str__(self) -> str:
        since = datetime.fromtimestamp(self.since, UTC)
        return f"process {self.pid} of host {self.host!r} since {since:%Y-%m-%d %H:%M:%S} UTC"


@contextmanager
def sole_owner(lock: Path, what: str, advice: str) -> Iterator[None]:
    """Hold a lock during the ``with`` block.

    The lock belongs to the open file (flock(2)): the kernel releases it when the process ends, also by SIGKILL, and
    processes that it starts do not inherit it. The file itself stays.

    Parameters
    ----------
    lock : Path
        The lock file; created if it is missing, readable by this user only.
    what : str
        Description of the owned thing, for the error.
    advice : str
        What the user can do if another process owns it, after "stop that process, or".

    Raises
    ------
    Unavailable
        Another process is the owner; the text names it.
    InvalidInput
        The lock file cannot be created.
    """
    try:
        handle = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, PRIVATE)
    except OSError as error:
        raise InvalidInput(f"cannot create {lock}: {error.strerror}; {advice}") from error
    try:
        _take(handle, lock, what, advice)
        yield
    finally:
        os.close(handle)


def _take(handle: int, lock: Path, what: str, advice: str) -> None:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise Unavailable(f"{what} is in use by {_owner(lock)}: stop that process, or {advice}") from error
    except OSError as error:  # a network file system without locks
        logger.warning("%s cannot be locked (%s): make sure that only one process uses it", what, error.strerror)
    owner = msgspec.json.encode(Owner(socket.gethostname(), os.getpid(), epoch()))
    try:
        os.ftruncate(handle, 0)
        os.pwrite(handle, owner, 0)
    except OSError as error:  # the lock holds; on a full disk its owner has no name
        logger.warning("cannot write the owner to %s: %s", lock, error.strerror)


def owner_of(lock: Path) -> Owner | None:
    """Return the process of this host that holds a lock; None if there is none."""
    try:
        with lock.open("rb") as handle:
            fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        owner = _written(lock)
        return owner if owner is not None and owner.host == socket.gethostname() else None
    except OSError:  # there is no such file, or it is on a network file system without locks
        return None
    return None


def _written(lock: Path) -> Owner | None:
    """Return the owner in a lock file, who may be writing it at this moment."""
    try:
        return from_json(lock.read_bytes(), Owner)
    except (OSError, msgspec.DecodeError):
        return None


def _owner(lock: Path) -> str:
    """Return a description of the owner."""
    return str(_written(lock) or "another process")
