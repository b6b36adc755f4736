"""A file of MCAP on the disk that is being written."""

import os
from pathlib import Path

from ppaas.recording.batches import About
from ppaas.recording.writer import Encoded, McapFile

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
