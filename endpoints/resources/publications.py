"""Publications of the maps that robots make, which are in progress: how far each is."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

import msgspec

from ppaas.decoding import from_json
from storage.store_errors import disk_errors


class Stage(StrEnum):
    """Stage of a publication, in their order."""

    TRANSFER = "transfer"
    """The pose graph, and the octomap if there is one, come from the robot's container."""
    WAITING = "waiting"
    """Other work of this user, or of others, comes first."""
    LOOPS = "loops"
    """Loops that are missing are searched for."""
    ALIGNMENT = "alignment"
    """All scans that overlap are aligned with each other."""
    DRAWING = "drawing"
    """The grid is drawn."""
    STORING = "storing"
    """The files are checked and stored."""


class PublicationProgress(NamedTuple):
    """Progress of a publication.

    Parameters
    ----------
    stage : Stage
    part : float
        Part of the stage that is done, from 0 to 1; 0 where it is not known.
    """

    stage: Stage
    part: float = 0.0


class ProgressFile:
    """File by which a program reports its progress to the process that started it.

    Parameters
    ----------
    folder : Path
        Folder of the file.
    """

    def __init__(self, folder: Path) -> None:
        self._path, self._new = folder / "progress", folder / "progress.new"

    def write(self, stage: Stage, part: float = 0.0) -> None:
        """Report a progress; raises ``Unavailable`` if the file cannot be written."""
        with disk_errors(self._path.parent):
            self._new.write_bytes(msgspec.json.encode(PublicationProgress(stage, part)))
            self._new.replace(self._path)

    def read(self) -> PublicationProgress | None:
        """Return the last progress; None if there is none."""
        with suppress(FileNotFoundError):
            return from_json(self._path.read_bytes(), PublicationProgress)
        return None


class RunningPublication:
    """A publication in progress.

    Attributes
    ----------
    stage : Stage
    file : ProgressFile, optional
        Where its program reports its progress, while it runs.
    """

    def __init__(self) -> None:
        self.stage = Stage.TRANSFER
        self.file: ProgressFile | None = None

    def progress(self) -> PublicationProgress:
        """Return how far it is; reads the file of its program."""
        file = self.file
        return (file.read() if file is not None else None) or PublicationProgress(self.stage)


class Publications:
    """Publications by user and robot; of a robot whose map is published several times at once, the last one.

    They belong to this endpoint: `GET` of a robot's map by way of another endpoint shows no progress of them.
    """

    def __init__(self) -> None:
        self._running: dict[tuple[str, str], RunningPublication] = {}

    @contextmanager
    def begin(self, user: str, robot: str) -> Iterator[RunningPublication]:
        """Register a publication until the end of the block."""
        key, publication = (user, robot), RunningPublication()
        self._running[key] = publication
        try:
            yield publication
        finally:
            if self._running.get(key) is publication:
                del self._running[key]

    def progress(self, user: str, robot: str) -> PublicationProgress | None:
        """Return how far the publication of a robot's map is; None if there is none. Reads a small file."""
        publication = self._running.get((user, robot))
        return None if publication is None else publication.progress()
