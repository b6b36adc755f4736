"""News and facts that the processes of a cloud exchange about the stores and about robots.

News say what one process changed in the stores, so that others drop it from caches. Facts about robots, such as how far
a publication is, are known to one process, and others ask for them.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Literal

from ppaas.errors import PPaaSError
from ppaas.listener_faults import ListenerFaults

logger = logging.getLogger(__name__)


# -- news --------------------------------------------------------------------------------------------------------------

NewsKind = Literal["map", "robot", "user"]
"""Kind of the record that was changed."""

Hear = Callable[[NewsKind, str], None]
"""Called with the kind and the key of a record that was changed."""


class News:
    """Passes news on to those who asked for them."""

    def __init__(self) -> None:
        self._listeners: list[Hear] = []
        self._faults = ListenerFaults(logger)

    def listen(self, hear: Hear) -> None:
        """Pass news on to a function, too."""
        self._listeners.append(hear)

    def leave(self, hear: Hear) -> None:
        """Stop passing news on to a function."""
        if hear in self._listeners:
            self._listeners.remove(hear)

    def tell(self, kind: NewsKind, key: str, *, source: Hear | None = None) -> None:
        """Pass a change on to all listeners but its source."""
        for hear in tuple(self._listeners):
            if hear != source:
                self._faults.call(f"a listener to news of a {kind}", hear, kind, key)


# -- facts -------------------------------------------------------------------------------------------------------------

FactKind = Literal["publication", "refusal", "sharing"]
"""Kind of a fact: progress of a publication, last refusal of a connect, other robots of the joint map."""

AskFact = Callable[[FactKind, str, str], Awaitable[bytes | None]]
"""Returns the fact of a user's robot as JSON, None if it is not known."""

TIMEOUT = 1.0
"""Time within which the others must answer [s]."""


class FactSources:
    """Processes that know facts about robots."""

    def __init__(self) -> None:
        self._sources: list[AskFact] = []

    def add(self, source: AskFact) -> None:
        """Ask a process, too."""
        self._sources.append(source)

    def remove(self, source: AskFact) -> None:
        """Stop asking a process."""
        if source in self._sources:
            self._sources.remove(source)

    async def ask(self, kind: FactKind, user: str, robot: str, *, but: AskFact | None = None) -> list[bytes]:
        """Return what all processes but one know of a robot, as JSON; those that do not answer are left out."""
        asked = [_answer(source, kind, user, robot) for source in self._sources if source != but]
        return [fact for fact in await asyncio.gather(*asked) if fact is not None]


async def _answer(source: AskFact, kind: FactKind, user: str, robot: str) -> bytes | None:
    try:
        async with asyncio.timeout(TIMEOUT):
            return await source(kind, user, robot)
    except (TimeoutError, PPaaSError):
        return None
