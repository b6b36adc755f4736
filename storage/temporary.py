"""Temporary folders of processes that may be killed, and files in folders that others can write to.

Each folder is locked by its process. The lock ends with the process, so the next one removes what a killed one left.
"""

import errno
import fcntl
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ppaas.clock import epoch
from storage.store_errors import disk_errors

PREFIX = "ppaas-map-"
"""Begin of the names of folders among the temporary files of the machine."""

YOUNG = 60.0
"""Age below which a folder without a lock is left alone: it may have been created a moment ago [s]."""


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Create a folder among this machine's temporary files, and remove it at the end of the block."""
    with disk_errors(Path(tempfile.gettempdir())):
        folder = Path(tempfile.mkdtemp(prefix=PREFIX))
        held = locked(folder)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(held)


def sweep_temporary_folders(base: Path) -> None:
    """Remove the temporary folders of this user's processes that were killed."""
    with suppress(OSError), os.scandir(base) as entries:
        for entry in entries:
            if entry.name.startswith(PREFIX) and _is_old_and_ours(entry):
                remove_unless_locked(Path(entry.path))


def locked(folder: Path) -> int:
    """Lock a folder; return its descriptor, which holds the lock while it is open."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    return handle


def remove_unless_locked(folder: Path) -> None:
    """Remove a folder unless its process is alive and holds the lock."""
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except FileNotFoundError:  # its process has just removed it
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return
    else:
        shutil.rmtree(folder, ignore_errors=True)
    finally:
        os.close(handle)


def _is_old_and_ours(entry: os.DirEntry[str]) -> bool:
    found = entry.stat(follow_symlinks=False)
    is_ours = stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid()
    return is_ours and found.st_mtime < epoch() - YOUNG


# Files in folders that other users of the computer can write to, such as the one for temporary files.
#
# Anybody may have put a FIFO there, on which an open waits for ever, a link to a file of somebody else, or a device
# without an end. So only regular files of the own user are read, without following a link, and only up to a limit.


def is_own_folder(path: Path) -> bool:
    """Return whether a path is a folder of this user, and no link."""
    return _is_own(path, stat.S_ISDIR)


def is_own_file(path: Path) -> bool:
    """Return whether a path is a regular file of this user, and no link."""
    return _is_own(path, stat.S_ISREG)


def _is_own(path: Path, is_kind: Callable[[int], bool]) -> bool:
    try:
        found = path.stat(follow_symlinks=False)
    except OSError:
        return False
    return is_kind(found.st_mode) and found.st_uid == os.geteuid()


def read_own(path: Path, limit: int) -> bytes:
    """Return the first bytes of a regular file of this user.

    Parameters
    ----------
    path : Path
    limit : int
        Most bytes to read.

    Raises
    ------
    OSError
        The file is missing, cannot be read, is no regular file, or belongs to another user.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(handle, "rb") as file:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode) or found.st_uid != os.geteuid():
            raise PermissionError(errno.EPERM, "not a regular file of this user", str(path))
        return file.read(limit)
