"""Folder of recordings: one folder a user and robot, with recordings and the segments of the ring.

::

    USER/ROBOT/20261126T224142Z.mcap        recording
    USER/ROBOT/20261126T224142Z.partial     recording in progress, or one that was cut off
    USER/ROBOT/ring/1795732902000000000.mcap   segment of the ring, by its begin [ns since the epoch]
"""

import math
import re
import shutil
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ppaas.errors import NotFound
from storage.names import check_name
from storage.store_errors import disk_errors

RECORDINGS = "recordings"
"""Name of the folder of the recordings of robots in a data folder."""

FINISHED, PARTIAL, RING = ".mcap", ".partial", "ring"
"""Endings of recordings that are complete and that are not, and the name of the folder of the ring."""

WRITTEN_NOW = 60.0
"""Time since the last write within which a file may be of a recording in progress [s]."""

_ID = re.compile(r"[0-9]{8}T[0-9]{6}Z(-[0-9]{1,3})?")


@dataclass(frozen=True, slots=True)
class StoredRecording:
    """A recording on the disk.

    Parameters
    ----------
    id : str
    path : Path
    size : int
        [bytes]
    changed : float
        Time of its last write [s since the epoch].
    finished : bool
        Whether it is complete, with an index.
    """

    id: str
    path: Path
    size: int
    changed: float
    finished: bool


@dataclass(frozen=True, slots=True)
class Segment:
    """A segment of a ring; its begin is in ns since the epoch."""

    begin: int
    path: Path
    size: int


def is_recording_id(text: str) -> bool:
    """Return whether a text is the id of a recording."""
    return _ID.fullmatch(text) is not None


class RecordingsFolder:
    """Folder of the recordings of all robots. Its functions block.

    Parameters
    ----------
    path : Path
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def of_robot(self, user: str, robot: str) -> Path:
        """Return the folder of a robot, which need not exist; raises ``InvalidInput`` for an invalid name."""
        return self.path / check_name("user", user) / check_name("robot", robot)

    def recordings(self, user: str, robot: str) -> list[StoredRecording]:
        """Return the recordings of a robot, newest first."""
        found = [
            stored
            for path in _files(self.of_robot(user, robot))
            if path.suffix in (FINISHED, PARTIAL) and is_recording_id(path.stem)
            if (stored := _stored(path)) is not None
        ]
        return sorted(found, key=lambda one: one.id, reverse=True)

    def recording(self, user: str, robot: str, id: str) -> StoredRecording:  # noqa: A002
        """Return one recording.

        Raises
        ------
        NotFound
            The robot has no such recording.
        """
        for ending in (FINISHED, PARTIAL):
            if is_recording_id(id) and (stored := _stored(self.of_robot(user, robot) / f"{id}{ending}")) is not None:
                return stored
        raise NotFound("recording", id)

    def segments(self, user: str, robot: str) -> list[Segment]:
        """Return the segments of the ring of a robot, oldest first."""
        found = []
        for path in _files(self.of_robot(user, robot) / RING):
            if path.suffix == FINISHED and path.stem.isdecimal():
                with suppress(FileNotFoundError):
                    found.append(Segment(int(path.stem), path, path.stat().st_size))
        return sorted(found, key=lambda one: one.begin)

    def size(self, user: str) -> int:
        """Return the size of all recordings of a user [bytes]."""
        total = 0
        for path in (self.path / check_name("user", user)).rglob("*"):
            with suppress(FileNotFoundError):
                total += path.stat().st_size if path.is_file() else 0
        return total

    def finished(self) -> list[Path]:
        """Return the files of all complete recordings, sorted; rings and recordings in progress are not among them."""
        return sorted(path for path in self.path.glob(f"*/*/*{FINISHED}") if is_recording_id(path.stem))

    def remove_recording(self, user: str, robot: str, id: str) -> None:  # noqa: A002
        """Remove a recording; raises as ``recording``."""
        path = self.recording(user, robot, id).path
        with disk_errors(path):
            path.unlink(missing_ok=True)

    def remove_ring(self, user: str, robot: str) -> None:
        """Remove the ring of a robot."""
        self._remove(self.of_robot(user, robot) / RING)

    def remove_robot(self, user: str, robot: str) -> None:
        """Remove all recordings of a robot."""
        self._remove(self.of_robot(user, robot))

    def remove_user(self, user: str) -> None:
        """Remove all recordings of a user."""
        self._remove(self.path / check_name("user", user))

    def expire(self, before: float, *, most: float = math.inf, now: float = math.inf, dry_run: bool = False) -> int:
        """Remove old recordings and segments, oldest first by their last write.

        Parameters
        ----------
        before : float
            What was written last before this time is removed [s since the epoch].
        most : float
            Size that the rest may have [bytes]. What was written within `WRITTEN_NOW` counts, and is not removed.
        now : float
            Time [s since the epoch].
        dry_run : bool
            Whether nothing is removed.

        Returns
        -------
        int
            Number that was removed.
        """
        paths = (path for path in self.path.rglob("*") if path.suffix in (FINISHED, PARTIAL) and path.is_file())
        found = [stored for path in paths if (stored := _stored(path)) is not None]
        left, removed = sum(stored.size for stored in found), 0
        for stored in sorted(found, key=lambda one: (one.changed, one.path)):
            if stored.changed >= before and (left <= most or stored.changed > now - WRITTEN_NOW):
                break
            left -= stored.size
            removed += 1
            if not dry_run:
                with disk_errors(stored.path):
                    stored.path.unlink(missing_ok=True)
        return removed

    @staticmethod
    def _remove(folder: Path) -> None:
        if folder.exists():
            with disk_errors(folder):
                shutil.rmtree(folder, ignore_errors=False)


def _files(folder: Path) -> Iterator[Path]:
    with suppress(FileNotFoundError, NotADirectoryError):
        yield from folder.iterdir()


def _stored(path: Path) -> StoredRecording | None:
    try:
        found = path.stat()
    except FileNotFoundError:
        return None
    return StoredRecording(path.stem, path, found.st_size, found.st_mtime, path.suffix == FINISHED)
