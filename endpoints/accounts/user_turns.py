"""Turns of users: the changes of one user happen one after the other, over all endpoints of a cloud."""

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from functools import partial
from typing import NamedTuple, Protocol, TypeVar

from starlette.concurrency import run_in_threadpool

from ppaas.bounded import BoundedDict
from ppaas.errors import Unavailable

T = TypeVar("T")

MAX_REMEMBERED = 10_000
"""Largest number of users whose last turn is remembered; the longest unused ones are forgotten first."""

MAX_WAITING = 1000
"""Largest number of changes of a user that wait for their turn."""


class Turn(NamedTuple):
    """Turn of a user.

    Parameters
    ----------
    id : str
        Id that no other turn has.
    before : str, optional
        Id of the user's turn before; None if it is not known. The endpoint that had it knows all changes so far.
    """

    id: str
    before: str | None


class UserTurns(Protocol):
    """Turns of users, of which each has one at a time."""

    def turn(self, user: str) -> AbstractAsyncContextManager[Turn]:
        """Wait for a turn of a user; it ends with the block.

        Raises
        ------
        Unavailable
            Too many changes of this user wait, or the process that gives the turns cannot be reached.
        """
        ...


class LocalTurns:
    """Turns that this process gives; for use on one event loop. They are first come, first served."""

    def __init__(self) -> None:
        self._queues: dict[str, _Queue] = {}
        self._last: BoundedDict[str, str] = BoundedDict(MAX_REMEMBERED)

    @asynccontextmanager
    async def turn(self, user: str) -> AsyncIterator[Turn]:
        """Wait for a turn of a user; it ends with the block."""
        queue = self._queues.setdefault(user, _Queue())
        if queue.length > MAX_WAITING:
            raise Unavailable(f"more than {MAX_WAITING} changes of user {user!r} wait: try again in a moment")
        queue.length += 1
        try:
            async with queue.turn:
                turn = Turn(secrets.token_hex(8), self._last.get(user))
                self._last[user] = turn.id
                yield turn
        finally:
            queue.length -= 1
            if not queue.length:
                del self._queues[user]


class _Queue:
    """Turn of one user, and the number of those who have it or wait for it."""

    def __init__(self) -> None:
        self.turn = asyncio.Lock()
        self.length = 0


async def in_turn(turns: UserTurns, user: str, work: Callable[[Turn], T]) -> T:
    """Return the result of blocking work, done in a thread during a turn of a user.

    The turn ends no sooner than the work: a caller that is cancelled waits for it.
    """
    async with turns.turn(user) as turn:
        return await _to_its_end(asyncio.ensure_future(run_in_threadpool(partial(work, turn))))


async def _to_its_end(working: asyncio.Future[T]) -> T:
    """Return the result of a thread, whose work goes on if the caller is cancelled."""
    cancelled: asyncio.CancelledError | None = None
    while not working.done():
        try:
            await asyncio.wait([working])
        except asyncio.CancelledError as error:
            cancelled = error
    if cancelled is not None:
        working.exception()  # nobody else asks for it
        raise cancelled
    return working.result()
