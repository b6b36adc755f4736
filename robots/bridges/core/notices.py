"""Messages for the user of a bridge, each of which is logged once."""

import logging
import re

from ppaas.bounded import BoundedDict
from ppaas.clock import monotonic

logger = logging.getLogger("ppaas.bridge")

MAX_NOTICES = 1000
"""Largest number of notices that are remembered; further ones are not logged."""

MAX_RECENT = 10
"""Largest number of warnings whose last times are known."""

_NUMBER = re.compile(r"(?<![\w'\"/.-])[-+]?\d+(?:\.\d+)?(?!\.?[\w'\"/])")
"""Number on its own in a text: digits in names and in quotes belong to these."""


def without_numbers(text: str) -> str:
    """Return a text with ``#`` for each number that stands alone: texts that then are the same are about one fault."""
    return _NUMBER.sub("#", text)


class Notices:
    """Log without repetitions.

    Parameters
    ----------
    most : int
        Largest number of notices that are logged and remembered.
    """

    def __init__(self, most: int = MAX_NOTICES) -> None:
        self._most = most
        self._given: set[str] = set()
        self._warned: BoundedDict[str, tuple[str, float]] = BoundedDict(MAX_RECENT)

    def info(self, text: str) -> None:
        """Log a piece of information, unless it was logged before."""
        self._log(logging.INFO, text, text)

    def warn(self, text: str) -> None:
        """Log a warning, unless one that differs in numbers only was; the doctor says each that is given repeatedly."""
        key = without_numbers(text)
        self._warned[key] = text, monotonic()
        self._log(logging.WARNING, text, key)

    def tell(self, text: str) -> None:
        """Log a warning that the doctor gets in another way, unless one that differs in numbers only was."""
        self._log(logging.WARNING, text, without_numbers(text))

    def recent(self, since: float) -> list[str]:
        """Return the warnings that were given after a monotonic time [s]."""
        return [text for text, at in self._warned.values() if at > since]

    def _log(self, level: int, text: str, key: str) -> None:
        if key not in self._given and len(self._given) < self._most:
            self._given.add(key)
            logger.log(level, "%s", text)
