"""Folders for temporary files that are removed when their process ends, also if it is killed.

Each folder is locked by its process. The lock ends with the process, so the next one removes what a killed one left.
"""

import fcntl
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ppaas.clock import epoch
from storage.store_errors import disk_errors

PREFIX = "ppaas-map-"
"""Begin of the names of folders among the temporary files of the machine."""

YOUNG = 60.0
"""Age below which a folder without a lock is left alone: it may have been created a moment ago [s]."""


@contextmanager
def temporary_folder(base: Path | None = None) -> Iterator[Path]:
    """Create a folder in ``base``, or among this machine's temporary files, and remove it at the end of the block."""
    with disk_errors(base or Path(tempfile.gettempdir())):
        folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=base))
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
