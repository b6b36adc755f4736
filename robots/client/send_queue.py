"""Send queue of a client: bounded and ordered; publishers either wait for space or replace their older frame."""

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from ppaas.errors import PPaaSError

SUBSCRIPTION = "subscription"
"""Key of frames that change subscriptions or advertised services; the greeting of a new session replaces them."""


@dataclass(slots=True)
class _Entry:
    frame: str
    newest_of: str | None = None
    bound: str | None = None


class SendQueue:
    """Queue of frames between the publishers and the task that sends.

    Frames are sent in order and counted; the cloud counts the frames that it receives. Sent frames are kept for a
    while. If the connection breaks and the cloud resumes the session, it reports its count, and the frames that it did
    not receive are sent again. If a new session begins, nobody knows which frames arrived, and sent frames are lost.

    Parameters
    ----------
    capacity : int
        Maximum number of queued frames, and of sent frames that are kept.
    """

    def __init__(self, capacity: int = 256) -> None:
        if capacity < 1:
            raise ValueError(f"capacity of a send queue must be 1 or more, not {capacity}")
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
        """Wake all waiting tasks; each checks its condition again."""
        # Replaced instead of cleared: all that wait wake, even if one of them changes the queue before the others run.
        self._changed.set()
        self._changed = asyncio.Event()

    async def _wait_until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            if self._error is not None:
                raise self._error
            await self._changed.wait()

    # -- queued frames -------------------------------------------------------------------------------------------------

    async def put(self, frame: str, bound: str | None = None) -> None:
        """Queue a frame that must not be dropped; wait while the queue is full.

        Parameters
        ----------
        frame : str
            The frame.
        bound : str, optional
            Key of a frame that is valid in this session only: the id of a call, ``ANSWER`` or ``SUBSCRIPTION``.

        Raises
        ------
        PPaaSError
            The error passed to ``close``.
        """
        await self._wait_until(lambda: len(self._entries) < self._capacity)
        self._entries.append(_Entry(frame, bound=bound))
        self._notify()

    def put_newest(self, key: str, frame: str) -> None:
        """Queue a frame in place of a queued frame of the same key, if there is one.

        The frame is dropped if the queue is full of other frames. ``dropped`` counts replaced and dropped frames.
        """
        for entry in self._entries:
            if entry.newest_of == key and entry is not self._sending:  # which may be on the wire already
                entry.frame = frame
                self.dropped += 1
                return
        if len(self._entries) >= self._capacity:
            self.dropped += 1
            return
        self._entries.append(_Entry(frame, newest_of=key))
        self._notify()

    def discard(self, bound: str) -> None:
        """Remove the queued frames of a key."""
        self._entries = deque(e for e in self._entries if e.bound != bound or e is self._sending)
        self._notify()

    def waiting(self) -> frozenset[str]:
        """Return the keys of the frames that have not been sent yet."""
        waiting = (entry for entry in self._entries if entry is not self._sending)
        return frozenset(entry.bound for entry in waiting if entry.bound is not None)

    async def filled(self) -> None:
        """Wait until the queue is not empty."""
        await self._wait_until(lambda: bool(self._entries))

    async def drained(self) -> None:
        """Wait until the queue is empty."""
        await self._wait_until(lambda: not self._entries)

    # -- sending -------------------------------------------------------------------------------------------------------

    async def next(self) -> str:
        """Wait for the next frame and return it; it stays queued until ``sent`` is called."""
        await self.filled()
        self._sending = self._entries[0]
        return self._sending.frame

    def sent(self) -> None:
        """Remove the frame that ``next`` returned, and count it as sent."""
        if self._entries and self._entries[0] is self._sending:
            self._entries.popleft()
            self._count += 1
            if self._sending.newest_of is None:  # of a stream, the next frame makes up for a lost one
                self._remembered.append((self._count, self._sending))
        self._sending = None
        self._notify()

    def resume(self, taken: int) -> None:
        """Resume the session of the lost connection.

        Parameters
        ----------
        taken : int
            Number of frames that the cloud has received in the session.
        """
        if self._sending is not None and taken > self._count:  # the frame that was being sent did arrive
            self._entries.popleft()
        self._sending = None
        again = [entry for number, entry in self._remembered if number > taken]
        self._entries.extendleft(reversed(again))
        self._remembered.clear()
        self._count = taken
        self._notify()

    def begin(self, greeting: list[str]) -> None:
        """Begin a new session: frames sent in the previous one are forgotten.

        Parameters
        ----------
        greeting : list of str
            Frames that renew subscriptions and advertised services.
        """
        unconfirmed, self._sending = self._sending, None
        if unconfirmed is not None and unconfirmed.bound is not None:
            self._entries.popleft()  # the call may have been executed: do not repeat it
        others = (entry for entry in self._entries if entry.bound != SUBSCRIPTION)
        self._entries = deque([*(_Entry(frame, bound=SUBSCRIPTION) for frame in greeting), *others])
        self._remembered.clear()
        self._count = 0
        self._notify()

    def close(self, error: PPaaSError) -> None:
        """Close the queue: calls that wait, now or later, raise the error."""
        self._error = error
        self._notify()
