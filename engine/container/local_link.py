"""Local link: the robot link between a clone and the sessions of its clients, within the container's process."""

import asyncio
from collections import deque
from collections.abc import Callable

from engine.protocols import robot_link


class LocalLink:
    """Both ends of a link without a stream: frames for the clone arrive at once, frames of the clone soon after.

    Parameters
    ----------
    take : callable
        Called with each frame of the clone.
    """

    waiting = 0
    """Number of written bytes that are still queued: none, since frames are not copied."""

    def __init__(self, take: Callable[[robot_link.FromContainer], None]) -> None:
        self._take = take
        self._queued: deque[robot_link.FromContainer] = deque()

    def write(self, frame: robot_link.FromContainer) -> None:
        """Pass on a frame of the clone once the clone is done with what it does now."""
        if not self._queued:
            asyncio.get_running_loop().call_soon(self._pass_on)
        self._queued.append(frame)

    def _pass_on(self) -> None:
        try:
            for _ in range(len(self._queued)):
                self._take(self._queued.popleft())
        finally:
            if self._queued:
                asyncio.get_running_loop().call_soon(self._pass_on)
