"""Turns of users: the changes of one user happen one after the other, over all endpoints of a cloud.

The master gives the turns; an endpoint asks it for them (`MasterTurns`).
"""

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from functools import partial
from typing import NamedTuple, Protocol, TypeVar

from starlette.concurrency import run_in_threadpool

from engine.calls.interface import remote
from engine.cloud_client.master_link import MasterLink, undone_if_cancelled
from engine.processes.background import Background
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


LONGEST = 120.0
"""Time after which a turn ends although its endpoint has not ended it [s]."""


class TurnCalls(Protocol):
    """Methods of the master that endpoints call."""

    async def take_turn(self, user: str) -> Turn:
        """Wait for a turn of a user; `end_turn` must follow."""
        ...

    async def end_turn(self, turn: str) -> None:
        """End a turn, given by its id."""
        ...


class MasterTurns:
    """Turns of the master, as an endpoint takes them; implements ``UserTurns``.

    Parameters
    ----------
    master : MasterLink
    """

    def __init__(self, master: MasterLink) -> None:
        self._master = master
        self._calls = remote(TurnCalls, master)

    @asynccontextmanager
    async def turn(self, user: str) -> AsyncIterator[Turn]:
        """Wait for a turn of a user; it ends with the block."""
        turn = await undone_if_cancelled(self._calls.take_turn(user), self._end)
        try:
            yield turn
        finally:
            self._end(turn)

    def _end(self, turn: Turn) -> None:
        self._master.tell(TurnCalls.end_turn, turn.id)


class ServedTurns:
    """Turns that one endpoint has; implements ``TurnCalls`` in the process of the master.

    Parameters
    ----------
    turns : UserTurns
        Turns of all endpoints.
    """

    def __init__(self, turns: UserTurns) -> None:
        self._turns = turns
        self._ends: dict[str, asyncio.Event] = {}
        self._background = Background()

    async def take_turn(self, user: str) -> Turn:
        """Wait for a turn of a user."""
        taken: asyncio.Future[Turn] = asyncio.get_running_loop().create_future()
        self._background.run(self._hold(user, taken))
        return await taken

    async def _hold(self, user: str, taken: asyncio.Future[Turn]) -> None:
        try:
            async with self._turns.turn(user) as turn:
                if taken.cancelled():
                    return
                end = self._ends[turn.id] = asyncio.Event()
                taken.set_result(turn)
                try:
                    async with asyncio.timeout(LONGEST):
                        await end.wait()
                except TimeoutError:
                    return
                finally:
                    del self._ends[turn.id]
        except Exception as error:
            if taken.done():
                raise
            taken.set_exception(error)

    async def end_turn(self, turn: str) -> None:
        """End a turn, given by its id."""
        end = self._ends.get(turn)
        if end is not None:
            end.set()

    def close(self) -> None:
        """End all turns of an endpoint that was lost."""
        for end in self._ends.values():
            end.set()
