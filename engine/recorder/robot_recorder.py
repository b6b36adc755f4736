"""Recorder of one robot: its ring, and the recording in progress."""

import logging
import os
from contextlib import suppress
from pathlib import Path

import msgspec

from ppaas.errors import MalformedMessage, QuotaExceeded, UnknownType
from ppaas.recording.batches import About, Batch, BatchedMessage
from ppaas.recording.parameters import selects
from ppaas.recording.writer import Encoded, McapFile, encoded
from storage.recordings import FINISHED, PARTIAL, RING, RecordingsFolder

logger = logging.getLogger(__name__)


# -- files -------------------------------------------------------------------------------------------------------------

FLUSH_PERIOD = 2.0
"""Period at which messages are compressed and written [s]: if the recorder is killed, those since are lost."""


class OpenFile:
    """File that is being written; only its user may read it.

    Parameters
    ----------
    path : Path
        A file that does not exist; its folder is created.
    about : About
    now : float
        Monotonic time [s].

    Raises
    ------
    OSError
        It cannot be written.
    """

    def __init__(self, path: Path, about: About, now: float) -> None:
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        self._stream = os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb")
        self._file = McapFile(self._stream, about)
        self.about = about
        self._flushed = now

    @property
    def size(self) -> int:
        """Number of bytes written."""
        return self._file.size

    def add(self, message: Encoded, *, log_time: int | None = None) -> None:
        """Add a message; ``log_time`` as in ``McapFile.add``."""
        self._file.add(message, log_time=log_time)

    def flush(self, now: float) -> None:
        """Write what was added, if it is time for it."""
        if now - self._flushed >= FLUSH_PERIOD:
            self._flushed = now
            self._file.flush()

    def finish(self) -> None:
        """Write the end of the file, and close it."""
        try:
            self._file.finish()
        finally:
            self._stream.close()

    def abandon(self) -> None:
        """Close the file as it is, since the disk takes nothing more; an empty one is removed."""
        # The buffer cannot be written, and closing the stream would try it again.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)
        self._stream.close()
        if self.path.stat().st_size == 0:
            self.path.unlink()


# -- rings and recordings ----------------------------------------------------------------------------------------------

SEGMENT = 20.0
"""Length of a segment of the ring [s]; the oldest is removed when all of it is too old."""

MOST_BYTES = 1 << 30
"""Largest size of a recording [bytes]."""

MOST_USER_BYTES = 4 << 30
"""Largest size of all recordings and rings of a user [bytes]."""

MOST_KEPT = 32 << 20
"""Largest size of the messages that are repeated at the begin of each file [bytes]."""

MOST_REFUSED = 100
"""Number of messages that cannot be encoded which are logged."""


class RobotRecorder:
    """Writes the messages of a robot. All functions raise ``OSError`` if the disk does not take them.

    Parameters
    ----------
    folder : RecordingsFolder
    user, robot : str
    """

    def __init__(self, folder: RecordingsFolder, user: str, robot: str) -> None:
        self._folder, self._user, self._robot = folder, user, robot
        self._kept: dict[tuple[str, bool], Encoded] = {}
        self._ring: OpenFile | None = None
        self._ring_began = 0.0
        self._recording: OpenFile | None = None
        self._recording_id = ""
        self._refused = 0

    def take(self, batch: Batch, now: float) -> None:
        """Write a batch.

        Parameters
        ----------
        batch : Batch
        now : float
            Monotonic time [s].

        Raises
        ------
        QuotaExceeded
            The recording or the recordings of the user are too large.
        """
        if batch.recording != self._recording_id:
            self._switch(batch, now)
        for entry in batch.entries:
            self._write(entry, batch, now)
        self.flush(now)

    def flush(self, now: float) -> None:
        """Write what was added, if it is time for it; begin the next segment of the ring."""
        if self._recording is not None:
            self._recording.flush(now)
            if self._recording.size > MOST_BYTES:
                raise QuotaExceeded(f"the recording has {MOST_BYTES >> 20} MiB, the largest size: it was ended")
        if self._ring is not None:
            self._ring.flush(now)
            if now - self._ring_began > SEGMENT:
                ring, self._ring = self._ring, None
                ring.finish()

    def finish(self) -> None:
        """Finish all files; the next batch begins new ones."""
        ring, self._ring = self._ring, None
        if ring is not None:
            ring.finish()
        self._end_recording()

    def abandon(self) -> None:
        """Close all files as they are, since the disk takes nothing more."""
        for file in (self._ring, self._recording):
            if file is not None:
                with suppress(OSError):
                    file.abandon()
        self._ring = self._recording = None
        self._recording_id = ""

    # -- messages ------------------------------------------------------------------------------------------------------

    def _write(self, entry: BatchedMessage, batch: Batch, now: float) -> None:
        if not entry.payload:
            self._kept.pop((entry.topic, entry.up), None)
            return
        for_ring, for_recording = selects(batch.ring_topics, entry.topic), selects(batch.recording_topics, entry.topic)
        if not (for_ring or (for_recording and self._recording is not None)):
            return
        try:
            message = encoded(entry)
        except (MalformedMessage, UnknownType) as error:
            self._refused += 1
            if self._refused <= MOST_REFUSED:
                logger.warning("a message of robot %s on %s is not recorded: %s", self._robot, entry.topic, error)
            return
        if for_ring:
            self._segment(batch, entry.log_time, now).add(message)
        if for_recording and self._recording is not None:
            self._recording.add(message)
        if entry.kept:
            self._keep(message)

    def _keep(self, message: Encoded) -> None:
        entry = message.entry
        self._kept[entry.topic, entry.up] = Encoded(msgspec.structs.replace(entry, payload=b""), message.data)
        if sum(len(kept.data) for kept in self._kept.values()) > MOST_KEPT:
            del self._kept[entry.topic, entry.up]

    def _repeat(self, file: OpenFile, globs: tuple[str, ...], log_time: int) -> None:
        for message in self._kept.values():
            if selects(globs, message.entry.topic):
                file.add(message, log_time=log_time)

    # -- files ---------------------------------------------------------------------------------------------------------

    def _segment(self, batch: Batch, begin: int, now: float) -> OpenFile:
        """Return the current segment of the ring, or a new one that begins at a time with the messages kept."""
        if self._ring is None or self._ring.about != batch.about or now - self._ring_began > SEGMENT:
            if self._ring is not None:
                self._ring.finish()
            self._check_space()
            self._prune(batch, begin)
            path = self._folder.of_robot(self._user, self._robot) / RING / f"{begin:019d}{FINISHED}"
            self._ring = OpenFile(_free(path), batch.about, now)
            self._ring_began = now
            self._repeat(self._ring, batch.ring_topics, begin)
        return self._ring

    def _prune(self, batch: Batch, begin: int) -> None:
        """Remove segments that end before the ring begins, and the oldest ones beyond its size."""
        segments = self._folder.segments(self._user, self._robot)
        if not segments:
            return
        oldest = begin - round(batch.ring_seconds * 1e9)
        total = sum(segment.size for segment in segments)
        ends = [segment.begin for segment in segments[1:]] + [begin]
        for segment, end in zip(segments, ends, strict=True):
            if end < oldest or total > batch.ring_bytes:
                segment.path.unlink(missing_ok=True)
                total -= segment.size

    def _switch(self, batch: Batch, now: float) -> None:
        """End the recording so far, and begin the batch's; one that was cut off is continued by another file."""
        self._end_recording()
        if not batch.recording:
            return
        self._check_space()
        path = _free(self._folder.of_robot(self._user, self._robot) / f"{batch.recording}{PARTIAL}")
        self._recording, self._recording_id = OpenFile(path, batch.about, now), batch.recording
        if batch.entries:
            self._repeat(self._recording, batch.recording_topics, batch.entries[0].log_time)

    def _end_recording(self) -> None:
        file, self._recording, self._recording_id = self._recording, None, ""
        if file is not None:
            file.finish()
            file.path.rename(file.path.with_suffix(FINISHED))

    def _check_space(self) -> None:
        if self._folder.size(self._user) > MOST_USER_BYTES:
            raise QuotaExceeded(
                f"the recordings of user {self._user!r} have {MOST_USER_BYTES >> 20} MiB, the most that one user may "
                "have: delete some"
            )


def _free(path: Path) -> Path:
    """Return a path with a number if a file of this name exists, whether complete or not."""
    stem, number = path.stem, 1
    while any(path.with_suffix(ending).exists() for ending in (FINISHED, PARTIAL)):
        number += 1
        if path.parent.name == RING:
            path = path.with_name(f"{int(stem) + number:019d}{path.suffix}")
        else:
            path = path.with_name(f"{stem}-{number}{path.suffix}")
    return path
