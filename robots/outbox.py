"""What waits to be sent: bounded, in order, and patient or not as each frame wants."""

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from ppaas.errors import PPaaSError


@dataclass(slots=True)
class _Entry:
    frame: str
    newest_of: str | None = None
    connection_bound: str | None = None


class Outbox:
    """A queue of frames between those who publish and the one task that sends.

    Frames are sent in the order in which they came. A frame stays in the queue until ``sent`` says that the connection
    has taken it; what it had not is sent on the next. What a connection had taken and not delivered when it broke is
    lost, since rosbridge acknowledges nothing.

    Parameters
    ----------
    capacity : int
        Frames that may wait.
    """

    def __init__(self, capacity: int = 256) -> None:
        if capacity < 1:
            raise ValueError(f"an outbox holds one frame or more, not {capacity}")
        self._capacity = capacity
        self._entries: deque[_Entry] = deque()
        self._sending: _Entry | None = None
        self._error: PPaaSError | None = None
        self._changed = asyncio.Event()
        self.dropped = 0

    def __len__(self) -> int:
        return len(self._entries)

    def _notify(self) -> None:
        """Wake all who wait; each looks again whether its time has come."""
        self._changed.set()
        self._changed = asyncio.Event()

    async def _until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            if self._error is not None:
                raise self._error
            await self._changed.wait()

    async def put(self, frame: str, connection_bound: str | None = None) -> None:
        """Queue a frame that must not be lost; waits while the queue is full.

        Parameters
        ----------
        frame : str
            The frame.
        connection_bound : str, optional
            A key, if the frame means nothing on another connection; see ``forget_connection``.

        Raises
        ------
        PPaaSError
            The one that ``close`` was given.
        """
        await self._until(lambda: len(self._entries) < self._capacity)
        self._entries.append(_Entry(frame, connection_bound=connection_bound))
        self._notify()

    def put_newest(self, key: str, frame: str) -> None:
        """Queue a frame that takes the place of one of the same key that still waits.

        Where the queue is full of other frames, this one is dropped; ``dropped`` counts both.
        """
        for entry in self._entries:
            if entry.newest_of == key and entry is not self._sending:
                entry.frame = frame
                self.dropped += 1
                return
        if len(self._entries) >= self._capacity:
            self.dropped += 1
            return
        self._entries.append(_Entry(frame, newest_of=key))
        self._notify()

    async def next(self) -> str:
        """Return the frame to send now; it stays until ``sent``."""
        await self._until(lambda: bool(self._entries))
        self._sending = self._entries[0]
        return self._sending.frame

    def sent(self) -> None:
        """Take away the frame that ``next`` returned."""
        if self._entries and self._entries[0] is self._sending:
            self._entries.popleft()
        self._sending = None
        self._notify()

    def forget_connection(self) -> None:
        """Drop what was bound to the connection that was lost: subscriptions are renewed, calls have failed."""
        self._sending = None
        self._entries = deque(entry for entry in self._entries if entry.connection_bound is None)
        self._notify()

    def discard(self, connection_bound: str) -> None:
        """Drop the frames of that key that still wait."""
        keep = (e for e in self._entries if e.connection_bound != connection_bound or e is self._sending)
        self._entries = deque(keep)
        self._notify()

    async def drained(self) -> None:
        """Wait until nothing waits any more."""
        await self._until(lambda: not self._entries)

    def close(self, error: PPaaSError) -> None:
        """Send nothing any more: who waits, or comes later and would have to wait, gets the error."""
        self._error = error
        self._notify()
