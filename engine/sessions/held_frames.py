"""Frames of a client that wait while the types of ROS are read for it.

A subscription in bytes of ROS (``compression: cbor-raw``) needs these types, and reading them takes most of a second of
CPU, once in a process. So they are read in a thread; the frames of other clients are handled meanwhile.
"""

import asyncio
from collections.abc import Callable
from typing import Final

from engine.protocols.session_frames import NumberedFrame
from ppaas.wire.ros.serialization import are_types_read, read_types

RAW: Final = b"cbor-raw"
"""Compression whose name in a frame makes it wait."""

MAX_SEARCHED: Final = 4096
"""Largest frame that is searched for the name [bytes]; a subscription is far smaller."""

MAX_HELD: Final = 1 << 20
"""Largest size of all frames that wait [bytes]; beyond it, none waits any longer."""


class HeldFrames:
    """Passes frames on in their order, the first with ``cbor-raw`` and what follows it once the types are read.

    Parameters
    ----------
    take : callable
        Called with each frame.
    """

    def __init__(self, take: Callable[[NumberedFrame], None]) -> None:
        self._take = take
        self._held: list[NumberedFrame] = []
        self._size = 0

    def waiting(self) -> list[NumberedFrame]:
        """Return the frames that wait, in order."""
        return [*self._held]

    def take(self, frame: NumberedFrame) -> None:
        """Pass a frame on, or let it wait."""
        if self._held:
            self._hold(frame)
        elif _asks_for_raw(frame) and not are_types_read():
            self._hold(frame)
            reading = asyncio.get_running_loop().run_in_executor(None, read_types)
            reading.add_done_callback(lambda _: self.release())
        else:
            self._take(frame)

    def release(self) -> None:
        """Pass on all frames that wait."""
        held, self._held, self._size = self._held, [], 0
        for frame in held:
            self._take(frame)

    def _hold(self, frame: NumberedFrame) -> None:
        self._held.append(frame)
        self._size += len(frame.content)
        if self._size > MAX_HELD:
            self.release()


def _asks_for_raw(frame: NumberedFrame) -> bool:
    return len(frame.content) <= MAX_SEARCHED and RAW in frame.content
