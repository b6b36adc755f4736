"""Heavy work: turns for it, and its last step, which a thread takes on the event loop.

Decoding of images and checks of octrees take seconds and hundreds of megabytes.
"""

import asyncio
from collections.abc import AsyncIterator, Callable, Coroutine
from concurrent.futures import wait
from contextlib import asynccontextmanager
from typing import Any, ParamSpec, TypeVar

from ppaas.errors import Unavailable

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


# Long work in a thread ends with a step that waits for its turn on the event loop.

P = ParamSpec("P")
T = TypeVar("T")

PERIOD = 1.0
"""Interval at which a waiting thread looks whether its event loop has ended [s]."""


def callable_in_thread(function: Callable[P, Coroutine[Any, Any, T]]) -> Callable[P, T]:
    """Return a function for threads that runs a coroutine function on the present event loop.

    It blocks until there is a result, and raises the errors of the coroutine; ``Unavailable`` if the loop has ended.
    """
    loop = asyncio.get_running_loop()

    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        running = function(*args, **kwargs)
        future = None if loop.is_closed() else asyncio.run_coroutine_threadsafe(running, loop)
        while future is None or not wait([future], PERIOD).done:
            if loop.is_closed():
                running.close()
                raise Unavailable("this server is stopping: try again in a moment")
        return future.result()

    return call
