"""Turns for heavy work: decoding of images and checks of octrees, which take seconds and hundreds of megabytes."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

MAX_AT_ONCE = 4
"""Number of requests with such work that run at once."""

MAX_OF_USER = 2
"""Number of these that run at once for one user, so others find a turn."""


class HeavyWork:
    """Turns of requests; for use on one event loop. They wait without a thread, first come, first served."""

    def __init__(self, at_once: int = MAX_AT_ONCE, of_user: int = MAX_OF_USER) -> None:
        self._at_once = asyncio.Semaphore(at_once)
        self._of_user = of_user
        self._users: dict[str, _UserTurns] = {}

    @asynccontextmanager
    async def turn(self, user: str) -> AsyncIterator[None]:
        """Wait for a turn of a user; it ends with the block."""
        async with self.turn_of_user(user), self._at_once:
            yield

    @asynccontextmanager
    async def turn_of_user(self, user: str) -> AsyncIterator[None]:
        """Wait for a turn among this user's turns only: for work that a slow client may prolong."""
        turns = self._users.setdefault(user, _UserTurns(self._of_user))
        turns.waiting += 1
        try:
            async with turns.free:
                yield
        finally:
            turns.waiting -= 1
            if not turns.waiting:
                del self._users[user]


class _UserTurns:
    """Turns of one user."""

    def __init__(self, count: int) -> None:
        self.free = asyncio.Semaphore(count)
        self.waiting = 0
