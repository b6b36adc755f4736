"""Turns of connections on the event loop: those with more frames than fit into one turn share what others leave."""

import asyncio
from collections import deque
from typing import Protocol
from weakref import WeakKeyDictionary

from ppaas.clock import Clock, monotonic

TURN = 0.002
"""Time of one turn, after which the event loop serves all others [s]; a frame that was begun is completed."""


class TurnTaker(Protocol):
    """Connection that waits for its turn."""

    def take_turn(self) -> None:
        """Process frames for up to `TURN`."""
        ...


class TurnQueue:
    """Connections that wait for their turn: in each iteration of the loop, as many as fit into `TURN`, at least one.

    Parameters
    ----------
    loop : AbstractEventLoop
        The event loop.
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, clock: Clock = monotonic) -> None:
        self._loop = loop
        self._clock = clock
        self._waiting: deque[TurnTaker] = deque()

    def __bool__(self) -> bool:
        """Return whether a connection waits."""
        return bool(self._waiting)

    def add(self, taker: TurnTaker) -> None:
        """Add a connection; its turn is in the next iteration of the loop, or after those that wait already."""
        if not self._waiting:
            self._loop.call_soon(self._run)
        self._waiting.append(taker)

    def _run(self) -> None:
        until = self._clock() + TURN
        for _ in range(len(self._waiting)):
            self._waiting.popleft().take_turn()
            if self._clock() >= until:
                break
        if self._waiting:
            self._loop.call_soon(self._run)


_queues: WeakKeyDictionary[asyncio.AbstractEventLoop, TurnQueue] = WeakKeyDictionary()


def turns_of(loop: asyncio.AbstractEventLoop) -> TurnQueue:
    """Return the turn queue of an event loop."""
    queue = _queues.get(loop)
    if queue is None:
        queue = _queues[loop] = TurnQueue(loop)
    return queue
