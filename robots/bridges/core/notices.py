"""Messages for the user of a bridge, each of which is logged once."""

import logging

from ppaas.bounded_dict import BoundedDict
from ppaas.clock import monotonic

logger = logging.getLogger("ppaas.bridge")

MAX_NOTICES = 1000
"""Largest number of notices that are remembered; further ones are not logged."""

MAX_RECENT = 10
"""Largest number of warnings whose last times are known."""


class Notices:
    """Log without repetitions."""

    def __init__(self) -> None:
        self._given: set[str] = set()
        self._warned: BoundedDict[str, float] = BoundedDict(MAX_RECENT)

    def info(self, text: str) -> None:
        """Log a piece of information, unless it was logged before."""
        self._log(logging.INFO, text)

    def warn(self, text: str) -> None:
        """Log a warning, unless it was logged before; the doctor says each that is given again and again."""
        self._warned[text] = monotonic()
        self.tell(text)

    def tell(self, text: str) -> None:
        """Log a warning that the doctor gets in another way, unless it was logged before."""
        self._log(logging.WARNING, text)

    def recent(self, since: float) -> list[str]:
        """Return the warnings that were given after a monotonic time [s]."""
        return [text for text, at in self._warned.items() if at > since]

    def _log(self, level: int, text: str) -> None:
        if text not in self._given and len(self._given) < MAX_NOTICES:
            self._given.add(text)
            logger.log(level, "%s", text)
