"""Pacing of one connection's frames: fair turns on the event loop, and a budget that ends a flood.

asyncio reads up to 256 KiB at once, which is thousands of small frames. Processed together, they would block the event
loop for all others. So they are processed in turns: after ``TURN`` seconds the rest of the block waits for the next
iteration of the loop, with reading paused. A connection that exceeds its budget waits longer, so TCP slows its peer
down. One that exceeds it for `OVERLOAD` seconds is reported, to be closed.
"""

import asyncio
import time
from collections import deque
from typing import Protocol
from weakref import WeakKeyDictionary

from ppaas.clock import Clock, monotonic

# Turns on the event loop: connections with more frames than fit into one turn share what others leave.

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


FRAMES = 4000.0
"""Rate of frames that alone uses the whole budget [1/s]; a robot with many sensors sends some hundreds."""

BYTES = 128 << 20
"""Rate of data that alone uses the whole budget [bytes/s]: twice the rate of raw 640×480 depth images at 30 Hz."""

BUSY = 0.5
"""Share of the event loop's time that alone uses the whole budget."""

STALL, STALLED = 0.05, 0.005
"""Time of a turn that others do not notice, and share of the event loop's time beyond it that alone uses the whole
budget [s]: a frame of 16 MiB may take 0.15 s, so there must not be many."""

BURST = 2.0
"""Time for which a connection may use its whole budget in advance [s]."""

OVERLOAD = 10.0
"""Time after which a connection that keeps exceeding its budget is closed [s]."""

BACKLOG = 4096
"""Block size [bytes] from which a connection over its budget counts as flooding. One that waits for the answer to each
request sends less, and is only slowed down."""


def frame_size(data: bytes, at: int) -> int:
    """Return the size of the frame that begins at ``at`` [bytes], or 0 if its header is incomplete (RFC 6455, 5.2)."""
    available = len(data) - at
    if available < 2:
        return 0
    length = data[at + 1] & 0x7F
    head = 6 if data[at + 1] & 0x80 else 2  # with the masking key
    if length < 126:
        return head + length
    extended = 2 if length == 126 else 8
    if available < 2 + extended:
        return 0
    return head + extended + int.from_bytes(data[at + 2 : at + 2 + extended])


class FrameBudget:
    """Frames, bytes and time that a connection has used, as one number.

    The number is the time at which the budget is whole again, as in the generic cell rate algorithm (ITU-T I.371,
    annex A).
    """

    def __init__(self) -> None:
        self._whole = 0.0

    def charge(self, frames: int, size: int, busy: float, now: float, stall: float = 0.0) -> float:
        """Charge frames, their size [bytes], and their processing time [s]; return the time to wait [s].

        ``stall`` is the CPU time of a turn that was measured [s].
        """
        used = frames / FRAMES + size / BYTES + busy / BUSY
        if stall > STALL:
            used += (stall - STALL) / STALLED
        self._whole = whole = (self._whole if self._whole > now else now) + used
        return whole - now - BURST


class PacedConnection(Protocol):
    """Connection whose frames are paced."""

    def feed(self, piece: bytes) -> None:
        """Process a frame, or a part of one."""
        ...

    def end_turn(self) -> None:
        """Handle the end of a turn."""
        ...

    def flooded(self) -> None:
        """Handle that the connection has exceeded its budget for `OVERLOAD`."""
        ...

    def pause_reading(self) -> None:
        """Stop reading from the peer."""
        ...

    def resume_reading(self) -> None:
        """Read from the peer again."""
        ...


class FramePacer:
    """Received data of one connection, processed frame by frame, in turns.

    Parameters
    ----------
    turns : TurnQueue
        Turns of all connections.
    connection : PacedConnection
        Processes the frames.
    clock : callable
        Returns monotonic time [s].
    cpu_clock : callable
        Returns the CPU time of the thread [s]. Reading it is a system call, so it is read only for connections that
        once had a long turn.

    Attributes
    ----------
    unfinished : int
        Size of the rest of the last frame, which has not been received yet [bytes].
    """

    def __init__(
        self,
        turns: TurnQueue,
        connection: PacedConnection,
        clock: Clock = monotonic,
        cpu_clock: Clock = time.thread_time,
    ) -> None:
        self._turns = turns
        self._connection = connection
        self._clock = clock
        self._cpu_clock = cpu_clock
        self._stalls = False
        self._budget = FrameBudget()
        self._data = b""
        self._at = 0
        self._waits = False
        self._stopped = False
        self._over_since: float | None = None
        self.unfinished = 0

    def stop(self) -> None:
        """Drop the received data, and all that follows."""
        self._stopped = True
        self._data, self._at = b"", 0

    def receive(self, data: bytes) -> None:
        """Process a block of data, or begin to."""
        if self._stopped:
            return
        self._data = data if self._at >= len(self._data) else self._data[self._at :] + data
        self._at = 0
        if self._waits:
            self._connection.pause_reading()  # ASGI had resumed it
            return
        if len(data) < BACKLOG:
            self._over_since = None
        elif self._turns:
            self._wait(0.0)
            return
        self._process()

    def take_turn(self) -> None:
        """Process waiting frames for up to ``TURN``."""
        if self._stopped:
            return
        self._waits = False
        self._process()
        if not self._waits:
            self._connection.resume_reading()

    def _process(self) -> None:
        clock, feed = self._clock, self._connection.feed
        began = now = clock()
        before, frames = self._at, 0
        spent = self._cpu_clock() if self._stalls else 0.0
        while now - began < TURN and (piece := self._next_piece()) is not None:
            feed(piece)
            frames += 1
            now = clock()
        if self._stopped:
            return
        self._connection.end_turn()
        stall = self._cpu_clock() - spent if self._stalls else 0.0
        self._stalls = self._stalls or now - began > STALL  # or the machine is busy: the next turn is measured
        delay = self._budget.charge(frames, self._at - before, now - began, now, stall)
        left = len(self._data) - self._at
        if delay > 0.0 or (now - began >= TURN and left):
            self._wait(max(delay, 0.0))
            self._check_flood(left, delay, now)

    def _next_piece(self) -> bytes | None:
        """Return the next frame, or as much of it as there is; None if there is none, or only a part of its header."""
        data, at = self._data, self._at
        size = self.unfinished or frame_size(data, at)
        available = len(data) - at
        if not size or not available:
            return None
        if size < available:
            self.unfinished = 0
            self._at = end = at + size
            return data[at:end]
        self.unfinished = size - available
        self._at = len(data)
        return data[at:] if at else data

    def _wait(self, delay: float) -> None:
        """Pause reading until the next turn, at the earliest after ``delay`` seconds."""
        self._waits = True
        self._connection.pause_reading()
        if delay > 0.0:
            asyncio.get_running_loop().call_later(delay, self._turns.add, self)
        else:
            self._turns.add(self)

    def _check_flood(self, left: int, delay: float, now: float) -> None:
        if delay <= 0.0 or left < BACKLOG:
            return
        if self._over_since is None:
            self._over_since = now
        elif now - self._over_since >= OVERLOAD:
            self._connection.flooded()
