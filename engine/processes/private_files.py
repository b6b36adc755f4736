"""Files and folders that only their owner may read."""

import logging
import os
import stat
from pathlib import Path

logger = logging.getLogger(__name__)

PRIVATE = 0o600
PRIVATE_FOLDER = 0o700
FOR_OTHERS = 0o077
"""Permissions of the group and of all other users."""


def write_private(path: Path, content: bytes) -> None:
    """Write a file atomically, readable only by this user; raises ``OSError`` if it cannot be written."""
    partial = path.with_name(f"{path.name}.{os.getpid()}")
    partial.unlink(missing_ok=True)
    descriptor = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, PRIVATE)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError:
        partial.unlink(missing_ok=True)  # on a full disk, half a file would take space
        raise


def keep_new_files_private() -> None:
    """Make all files and folders that this process and its children create accessible to their user only."""
    os.umask(FOR_OTHERS)


def make_private_folder(folder: Path) -> None:
    """Create a folder that only this user may enter; warn if it exists and others may enter it.

    The permissions of an existing folder are not changed: somebody may have chosen them.

    Raises
    ------
    OSError
        The folder cannot be created.
    """
    folder.mkdir(mode=PRIVATE_FOLDER, parents=True, exist_ok=True)
    warn_if_open(folder)


def warn_if_open(path: Path) -> None:
    """Log a warning with advice if other users of this computer have access to an existing file or folder."""
    mode = stat.S_IMODE(path.stat().st_mode)
    if mode & FOR_OTHERS:
        option = "-R " if path.is_dir() else ""
        logger.warning(
            "other users of this computer have access to %s (mode %04o): run 'chmod %sgo= %s'", path, mode, option, path
        )
