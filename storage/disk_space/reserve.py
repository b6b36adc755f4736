"""Reserve of disk space: a file that is removed when the disk is full, so that space can still be freed.

While the reserve is set aside, everything is stored. When the disk is full, it is given up: tokens can then still be
issued and revoked, and data removed, but nothing else is stored (``storage.disk_space.guarded``) until there is space
for a new reserve. All processes of a cloud on this machine check for the file itself.
"""

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Literal, NamedTuple

RESERVE = "disk-reserve"
"""Name of the reserve in a data folder."""

MIN_RESERVE, MAX_RESERVE, RESERVE_FRACTION = 1 << 20, 16 << 20, 0.01
"""Bounds of its size [bytes], and its size in proportion to the disk."""

LOW, LOW_FRACTION = 1 << 30, 0.05
"""Free space that counts as low: the smaller of a size [bytes] and a fraction of the disk."""

MIN_FREE_FRACTION = 0.25
"""Free space below which the disk counts as full, in proportion to the reserve."""

SpaceState = Literal["ok", "low", "full"]


class DiskSpace(NamedTuple):
    """Size and free space of a disk for this user [bytes], and the number of files that can be created."""

    total: int
    free: int
    files: int

    @classmethod
    def of(cls, folder: Path) -> "DiskSpace":
        """Measure the disk of a folder; ``OSError`` if it cannot be measured."""
        found = os.statvfs(folder)
        files = found.f_favail if found.f_files else 1  # some file systems have no limit and report no numbers
        return cls(found.f_blocks * found.f_frsize, found.f_bavail * found.f_frsize, files)


class DiskReserve:
    """The reserve on the disk of a folder. Thread-safe.

    Parameters
    ----------
    folder : Path
        The data folder.
    measure : callable
        Measures the disk of a folder; raises ``OSError`` if it cannot be measured.
    """

    def __init__(self, folder: Path, measure: Callable[[Path], DiskSpace] = DiskSpace.of) -> None:
        self._folder = folder
        self._file = folder / RESERVE
        self._measure = measure
        self._lock = threading.Lock()

    def size(self, space: DiskSpace) -> int:
        """Return the size of the reserve for a disk [bytes]."""
        return int(min(max(MIN_RESERVE, RESERVE_FRACTION * space.total), MAX_RESERVE))

    def space(self) -> DiskSpace:
        """Measure the disk; ``OSError`` if it cannot be measured."""
        return self._measure(self._folder)

    def state(self) -> SpaceState:
        """Return the state of the disk: full if the reserve was given up, or nearly no space is left beside it."""
        space = self.space()
        if self._is_used_up(space) or not self._file.exists():
            return "full"
        return "low" if space.free < min(LOW, LOW_FRACTION * space.total) else "ok"

    def is_full(self) -> bool:
        """Return whether the disk is full; a disk that cannot be measured is not."""
        try:
            return self.state() == "full"
        except OSError:
            return False

    def keep(self) -> SpaceState:
        """Give the reserve up if the disk is full, and set it aside if there is space; return the new state.

        Only the owner of the data folder calls this, when it starts and then every second.
        """
        with self._lock:
            space = self.space()
            if self._is_used_up(space):
                self._file.unlink(missing_ok=True)
            elif not self._file.exists() and space.free >= 2 * self.size(space):
                self._set_aside(self.size(space))
            return self.state()

    def release(self) -> None:
        """Remove the reserve when the owner of the data folder ends; does nothing if the disk fails."""
        with self._lock, suppress(OSError):
            self._file.unlink(missing_ok=True)

    def _is_used_up(self, space: DiskSpace) -> bool:
        return space.free < MIN_FREE_FRACTION * self.size(space) or space.files < 1

    def _set_aside(self, size: int) -> None:
        partial = self._file.with_name(f"{RESERVE}.partial")
        try:
            handle = os.open(partial, os.O_WRONLY | os.O_CREAT, 0o600)
            try:
                os.posix_fallocate(handle, 0, size)
            finally:
                os.close(handle)
            partial.replace(self._file)
        except OSError:  # the space was taken meanwhile
            with suppress(OSError):
                partial.unlink(missing_ok=True)
