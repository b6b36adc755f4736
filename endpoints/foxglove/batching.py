"""Frames that are sent together: many robots send small messages, and each write costs as much as a large one."""

import asyncio

from endpoints.http.websocket_protocol import DirectWebSocket

PERIOD = 0.01
"""Time for which a frame waits for others [s]."""

MAX_WAITING = 64 << 10
"""Size of the waiting frames at which they are sent at once [bytes]."""


class BatchingConnection:
    """Connection that sends the frames of a short time at once.

    Parameters
    ----------
    connection : DirectWebSocket
    """

    def __init__(self, connection: DirectWebSocket) -> None:
        self._connection = connection
        self._frames: list[bytes] = []
        self._bytes = 0
        self._timer: asyncio.TimerHandle | None = None

    @property
    def ready(self) -> bool:
        """True while frames can be sent."""
        return self._connection.ready

    def send_frame(self, frame: bytes) -> None:
        """Send a frame soon; call it only while ``ready``."""
        self._frames.append(frame)
        self._bytes += len(frame)
        if self._bytes >= MAX_WAITING:
            self.flush()
        elif self._timer is None:
            self._timer = asyncio.get_running_loop().call_later(PERIOD, self.flush)

    def flush(self) -> None:
        """Send what waits, unless the connection is closed."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        frames, self._frames, self._bytes = self._frames, [], 0
        if frames and self._connection.ready:
            self._connection.send_frames(frames)
