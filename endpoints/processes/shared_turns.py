"""Turns of users that the master gives to all endpoints."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Protocol

from endpoints.accounts.user_turns import Turn, UserTurns
from engine.calls.interface import remote
from engine.endpoint.master_link import MasterLink, undone_if_cancelled
from engine.processes.background import Background

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
