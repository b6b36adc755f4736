"""Beat file: a process shows with it that its event loop runs, to a keeper that is not connected with it."""

import os
from pathlib import Path


class BeatFile:
    """File whose time of modification is the last heartbeat of a process.

    Parameters
    ----------
    folder : Path
        Folder of the file.
    name : str
        Name of the process.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self._path = folder / f"{name}.beat"

    def beat(self) -> None:
        """Record a heartbeat; raises ``OSError`` if the folder is gone."""
        try:
            os.utime(self._path)  # takes no space, so it works on a full disk
        except FileNotFoundError:
            self._path.touch(mode=0o600)

    def last(self) -> int | None:
        """Return a number that changes with each heartbeat; None before the first."""
        try:
            return self._path.stat().st_mtime_ns
        except FileNotFoundError:
            return None

    def clear(self) -> None:
        """Forget the heartbeats of an earlier process."""
        self._path.unlink(missing_ok=True)
