"""Facts about robots that one process of a cloud knows and others ask for, such as how far a publication is."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Literal

from ppaas.errors import PPaaSError

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
