"""Folder of a process's Unix sockets, with a path short enough to bind them."""

import contextlib
import os
import re
import shutil
import tempfile
import time
from multiprocessing.util import Finalize
from pathlib import Path

from engine.processes.instances import instance_name, is_dead
from ppaas.errors import InvalidInput
from storage.own_files import is_own_folder, read_own
from storage.temporary import sweep_temporary_folders

LONGEST_PATH = 107
"""Longest path of a Unix socket without the terminating zero [bytes] (``sun_path`` in unix(7))."""

LONGEST_NAME = len("pymp-12345678/listener-12345678")
"""Longest name of a socket in the folder [bytes]: the name that the standard library's fork server uses."""

PREFIX = "ppaas-"
_NAME = re.compile(rf"{PREFIX}[a-z0-9_]{{8}}")
"""Names that `tempfile.mkdtemp` gives to folders with this prefix."""

OWNER = "owner"
"""File with the owners of the folder, one process per line: the folder can be removed when all of them are dead."""

MOST_OWNERS = 1 << 16
"""Bytes of that file that are read; a line has some tens."""

BEING_MADE = 1.0
"""Age up to which an empty folder may be one that a process has just made and does not own yet [s]."""

AFTER_ALL_OTHERS = -1000
"""Priority of a clean-up at exit that runs last: priorities of the standard library go down to -100."""


def make_run_dir(longest: int = LONGEST_NAME) -> Path:
    """Create a folder for sockets, private to this user, and remove folders of dead processes.

    Parameters
    ----------
    longest : int
        Length of the longest name of a socket in it [bytes].

    Raises
    ------
    InvalidInput
        The path of the folder for temporary files is too long for sockets.
    OSError
        The folder could not be created.
    """
    sweep_dead(Path(tempfile.gettempdir()))
    sweep_temporary_folders(Path(tempfile.gettempdir()))
    folder = Path(tempfile.mkdtemp(prefix=PREFIX))
    if len(bytes(folder)) + 1 + longest > LONGEST_PATH:
        shutil.rmtree(folder)
        raise InvalidInput(f"the path {folder.parent} is too long for Unix sockets; set TMPDIR to a shorter one")
    try:
        add_owner(folder)
    except FileNotFoundError:  # it was swept, because this process was stopped in between
        return make_run_dir(longest)
    return folder


def add_owner(folder: Path) -> None:
    """Add this process to the owners of a folder; it is kept until all of them have exited."""
    handle = os.open(folder / OWNER, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW, 0o600)
    with os.fdopen(handle, "w") as owners:
        owners.write(f"{instance_name()}\n")


def sweep_dead(base: Path) -> None:
    """Remove the folders of processes that were killed, also while they made or removed a folder."""
    for folder in base.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):  # another process removes it
            _sweep(folder)


def _sweep(folder: Path) -> None:
    try:
        owners = owners_of(folder)
    except FileNotFoundError:
        if _NAME.fullmatch(folder.name) and time.time() - folder.stat().st_mtime > BEING_MADE:
            folder.rmdir()  # unless there is something in it
        return
    if owners and all(map(is_dead, owners)):
        _remove(folder)


def owners_of(folder: Path) -> list[str]:
    """Return the owners of a folder; none of a folder of another user, who may have put anything there.

    Raises
    ------
    OSError
        The folder, or its list of owners, is missing or cannot be read.
    """
    if not is_own_folder(folder):
        return []
    return read_own(folder / OWNER, MOST_OWNERS).decode(errors="replace").split()


def keep_temporary_files_in(folder: Path) -> None:
    """Make this process and its children create temporary files in a folder that is certain to be removed."""
    os.environ["TMPDIR"] = tempfile.tempdir = str(folder)


def remove_unless_owned(folder: Path) -> None:
    """Remove a folder, as ``remove_folder`` does, unless another running process owns it."""
    try:
        owners = owners_of(folder)
    except FileNotFoundError:
        owners = []
    if all(owner == instance_name() or is_dead(owner) for owner in owners):
        remove_folder(folder)


def remove_folder(folder: Path) -> None:
    """Remove a folder and its content, as far as possible.

    If this process keeps its temporary files there, the folder is removed at exit, after the standard library has
    removed its own files.
    """
    if Path(tempfile.gettempdir()) == folder:
        Finalize(None, _remove, (folder,), exitpriority=AFTER_ALL_OTHERS)
    else:
        _remove(folder)


def _remove(folder: Path) -> None:
    """Remove a folder, its list of owners last: what is left if this process is killed meanwhile is removed later."""
    with contextlib.suppress(OSError):
        for entry in folder.iterdir():
            if entry.is_dir() and not entry.is_symlink():
                shutil.rmtree(entry, ignore_errors=True)
            elif entry.name != OWNER:
                entry.unlink(missing_ok=True)
    shutil.rmtree(folder, ignore_errors=True)
