"""Files in folders that other users of the computer can write to, such as the one for temporary files.

Anybody may have put a FIFO there, on which an open waits for ever, a link to a file of somebody else, or a device
without an end. So only regular files of the own user are read, without following a link, and only up to a limit.
"""

import errno
import os
import stat
from collections.abc import Callable
from pathlib import Path


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
