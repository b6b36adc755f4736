"""Folder of numba's cache: if none of those that numba would use can be written, one in memory for this run.

Without any, kernels could not even be imported, and the compiler could hand nothing to the containers.
"""

import atexit
import contextlib
import logging
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import ppaas
from engine.processes.instances import SHARED_MEMORY, folder_of, instance_name

logger = logging.getLogger(__name__)

VARIABLE = "NUMBA_CACHE_DIR"


def ensure_cache() -> None:
    """Cache kernels of this process and its children in memory, if nowhere else; call it before numba is imported.

    The folder is removed when this process ends, or swept by the next one after it was killed.
    """
    if is_writable():
        return
    for base in (SHARED_MEMORY, Path(tempfile.gettempdir())):
        folder = folder_of(instance_name(), base) / "kernels"
        if _can_write(folder):
            os.environ[VARIABLE] = str(folder)
            atexit.register(shutil.rmtree, folder.parent, ignore_errors=True)
            logger.warning(
                "no folder for compiled kernels can be written: they are kept in memory, and the next start compiles "
                "them again, for some minutes; set %s to a folder that can be written",
                VARIABLE,
            )
            return


def is_writable() -> bool:
    """Return whether one of the folders that numba would use can be written."""
    return any(map(_can_write, _usual()))


def _usual() -> Iterator[Path]:
    """Yield the folders that numba would use: the given one, the sources' folder, and the user's."""
    if given := os.environ.get(VARIABLE):
        yield Path(given)
    yield Path(ppaas.__path__[0], "planners", "grid", "kernels", "__pycache__")
    with contextlib.suppress(RuntimeError):  # this user has no home
        yield Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser(), "numba")


def _can_write(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False
