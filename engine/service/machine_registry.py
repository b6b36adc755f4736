"""Machine registry: machine names on disk, for a cloud process that starts after this one was killed."""

import logging
from collections.abc import Iterable
from pathlib import Path

import msgspec

from engine.processes.disk_notes import write_note
from ppaas.decoding import from_json

logger = logging.getLogger(__name__)


class MachineRegistry:
    """Names of the connected machines, on disk.

    Parameters
    ----------
    file : Path
        The file. It exists while machines are connected, and after a cloud process was killed.
    """

    def __init__(self, file: Path) -> None:
        self._file = file

    def left(self) -> list[str]:
        """Return the machines of a killed cloud process; empty if there are none, or the file is not readable."""
        try:
            return from_json(self._file.read_bytes(), list[str])
        except (OSError, msgspec.DecodeError):
            return []  # robots then do not wait for machines, and only get new containers

    def note(self, machines: Iterable[str]) -> None:
        """Store the names of the machines; without machines, delete the file."""
        names = sorted(machines)
        try:
            if names:
                write_note(self._file, names)
            else:
                self._file.unlink(missing_ok=True)
        except OSError as error:
            logger.warning(
                "could not store the names of machines; if this process is killed, robots do not wait for them: %s",
                error,
            )
