"""The folder of a process's Unix sockets: short enough that each can be bound."""

import contextlib
import os
import shutil
import tempfile
from multiprocessing.util import Finalize
from pathlib import Path

from engine.processes.instances import instance_name, is_dead
from ppaas.errors import InvalidInput

LONGEST_PATH = 107
"""Bytes of a Unix socket's path, without its terminating zero (``sun_path`` in unix(7))."""

LONGEST_NAME = len("pymp-12345678/listener-12345678")
"""Bytes of a socket's name in the folder: the longest is that of the fork server, by Python's library."""


OWNER = "owner"
"""File in the folder that tells whose it is, a process a line, so that it can be removed when all were killed."""


AFTER_ALL_OTHERS = -1000
"""Among the things that are done when a process ends; those of Python's library go down to -100."""


def make_run_dir(longest: int = LONGEST_NAME) -> Path:
    """Make a folder for sockets, which this user alone may enter, and remove those of processes that are dead.

    Parameters
    ----------
    longest : int
        Bytes of the longest name of a socket in it.

    Raises
    ------
    InvalidInput
        The folder for temporary files has so long a path that no socket could be bound in it.
    OSError
        The folder could not be made.
    """
    sweep_dead(Path(tempfile.gettempdir()))
    folder = Path(tempfile.mkdtemp(prefix="ppaas-"))
    if len(bytes(folder)) + 1 + longest > LONGEST_PATH:
        shutil.rmtree(folder)
        raise InvalidInput(f"{folder.parent} has too long a path for Unix sockets; set TMPDIR to a shorter one")
    own(folder)
    return folder


def own(folder: Path) -> None:
    """Own a folder, beside those who do already: it stays until all of them are gone."""
    with (folder / OWNER).open("a") as owners:
        owners.write(f"{instance_name()}\n")


def sweep_dead(base: Path) -> None:
    """Remove the folders of processes that ended without removing them."""
    for owner in base.glob(f"ppaas-*/{OWNER}"):
        with contextlib.suppress(OSError):  # another sweeps as well, or it is somebody else's
            owners = owner.read_text().split()
            if owners and all(map(is_dead, owners)):
                shutil.rmtree(owner.parent, ignore_errors=True)


def keep_temporary_files_in(folder: Path) -> None:
    """Have this process and those that it starts make temporary files in a folder that somebody removes for certain."""
    os.environ["TMPDIR"] = tempfile.tempdir = str(folder)


def remove_unless_owned(folder: Path) -> None:
    """Remove a folder that nobody else owns and lives, as ``remove_folder`` does."""
    try:
        owners = (folder / OWNER).read_text().split()
    except FileNotFoundError:
        owners = []
    if all(owner == instance_name() or is_dead(owner) for owner in owners):
        remove_folder(folder)


def remove_folder(folder: Path) -> None:
    """Remove a folder with all in it, as far as that can be done.

    Where this process keeps its temporary files there, that is when it ends: Python's library removes its own before,
    and would miss them.
    """
    if Path(tempfile.gettempdir()) == folder:
        Finalize(None, shutil.rmtree, (folder, True), exitpriority=AFTER_ALL_OTHERS)
    else:
        shutil.rmtree(folder, ignore_errors=True)
