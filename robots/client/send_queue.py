"""What waits to be sent: bounded, in order, and patient or not as each frame wants."""

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from ppaas.errors import PPaaSError

SUBSCRIPTION = "subscription"
"""What frames are bound to that tell what is subscribed or offered: where a session begins anew, its greeting says it
all."""


@dataclass(slots=True)
class _Entry:
    frame: str
    newest_of: str | None = None
    bound: str | None = None


class Outbox:
    """A queue of frames between those who publish and the one task that sends.

    Frames are sent in the order in which they came, and counted, as the cloud counts those that it takes. A frame that
    was sent is remembered: if the connection breaks and the cloud kept the session, it says how many it took, and what
    it did not is sent again, once. Where the session begins anew nobody knows what arrived, and what was sent is lost.

    Parameters
    ----------
    capacity : int
        Frames that may wait, and those that are remembered.
    """

    def __init__(self, capacity: int = 256) -> None:
        if capacity < 1:
            raise ValueError(f"an outbox holds one frame or more, not {capacity}")
        self._capacity = capacity
        self._entries: deque[_Entry] = deque()
        self._sending: _Entry | None = None
        self._count = 0
        self._remembered: deque[tuple[int, _Entry]] = deque(maxlen=capacity)
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

    # -- what waits ----------------------------------------------------------------------------------------------------

    async def put(self, frame: str, bound: str | None = None) -> None:
        """Queue a frame that must not be lost; waits while the queue is full.

        Parameters
        ----------
        frame : str
            The frame.
        bound : str, optional
            A key, if the frame means nothing in another session: of a call, an answer, or ``SUBSCRIPTION``.

        Raises
        ------
        PPaaSError
            The one that ``close`` was given.
        """
        await self._until(lambda: len(self._entries) < self._capacity)
        self._entries.append(_Entry(frame, bound=bound))
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

    def discard(self, bound: str) -> None:
        """Drop the frames of that key that still wait."""
        self._entries = deque(e for e in self._entries if e.bound != bound or e is self._sending)
        self._notify()

    def waiting(self) -> frozenset[str]:
        """Return the keys to which frames are bound that were not sent yet."""
        waiting = (entry for entry in self._entries if entry is not self._sending)
        return frozenset(entry.bound for entry in waiting if entry.bound is not None)

    async def filled(self) -> None:
        """Wait until there is something to send."""
        await self._until(lambda: bool(self._entries))

    async def drained(self) -> None:
        """Wait until nothing waits any more."""
        await self._until(lambda: not self._entries)

    # -- what is sent --------------------------------------------------------------------------------------------------

    async def next(self) -> str:
        """Return the frame to send now; it stays until ``sent``."""
        await self.filled()
        self._sending = self._entries[0]
        return self._sending.frame

    def sent(self) -> None:
        """Take away the frame that ``next`` returned."""
        if self._entries and self._entries[0] is self._sending:
            self._entries.popleft()
            self._count += 1
            if self._sending.newest_of is None:
                self._remembered.append((self._count, self._sending))
        self._sending = None
        self._notify()

    def resume(self, taken: int) -> None:
        """Go on in the session of the connection that was lost.

        Parameters
        ----------
        taken : int
            Frames that the cloud took in it.
        """
        if self._sending is not None and taken > self._count:  # the last frame arrived, though we never heard so
            self._entries.popleft()
        self._sending = None
        again = [entry for number, entry in self._remembered if number > taken]
        self._entries.extendleft(reversed(again))
        self._remembered.clear()
        self._count = taken
        self._notify()

    def begin(self, greeting: list[str]) -> None:
        """Begin a new session with a greeting: what was sent in another one is forgotten.

        Parameters
        ----------
        greeting : list of str
            Frames that tell what is subscribed and offered.
        """
        doubtful, self._sending = self._sending, None
        if doubtful is not None and doubtful.bound is not None:
            self._entries.popleft()  # a call that may have been carried out is not made again unasked
        others = (entry for entry in self._entries if entry.bound != SUBSCRIPTION)
        self._entries = deque([*(_Entry(frame, bound=SUBSCRIPTION) for frame in greeting), *others])
        self._remembered.clear()
        self._count = 0
        self._notify()

    def close(self, error: PPaaSError) -> None:
        """Send nothing any more: who waits, or comes later and would have to wait, gets the error."""
        self._error = error
        self._notify()
