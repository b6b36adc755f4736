"""Messages for the user of a bridge, each of which is logged once."""

import logging

logger = logging.getLogger("ppaas.bridge")

MAX_NOTICES = 1000
"""Largest number of notices that are remembered; further ones are not logged."""


class Notices:
    """Log without repetitions."""

    def __init__(self) -> None:
        self._given: set[str] = set()

    def info(self, text: str) -> None:
        """Log a piece of information, unless it was logged before."""
        self._log(logging.INFO, text)

    def warn(self, text: str) -> None:
        """Log a warning, unless it was logged before."""
        self._log(logging.WARNING, text)

    def _log(self, level: int, text: str) -> None:
        if text not in self._given and len(self._given) < MAX_NOTICES:
            self._given.add(text)
            logger.log(level, "%s", text)
