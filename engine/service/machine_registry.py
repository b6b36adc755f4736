"""Which machines a cloud has, noted for a cloud process that is started after this one was killed."""

import logging
from collections.abc import Iterable
from pathlib import Path

import msgspec

from engine.processes.disk_notes import write_note

logger = logging.getLogger(__name__)


class Roll:
    """The names of the machines, on the disk.

    Parameters
    ----------
    file : Path
        It is not there while no cloud runs, unless that was killed.
    """

    def __init__(self, file: Path) -> None:
        self._file = file

    def left(self) -> list[str]:
        """Return the machines of a cloud process that was killed."""
        try:
            return msgspec.json.decode(self._file.read_bytes(), type=list[str])
        except (OSError, msgspec.DecodeError):
            return []  # nobody waits for machines then, which costs no more than containers that are made anew

    def note(self, machines: Iterable[str]) -> None:
        """Note which machines there are now."""
        names = sorted(machines)
        try:
            if names:
                write_note(self._file, names)
            else:
                self._file.unlink(missing_ok=True)
        except OSError as error:
            logger.warning("should this process be killed, no robot waits for its machines: %s", error)
