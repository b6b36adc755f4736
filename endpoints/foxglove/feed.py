"""Feed of a channel: messages of a topic, converted, on their way to a viewer."""

import asyncio
from collections.abc import Callable

from ppaas.errors import PPaaSError
from ppaas.wire.foxglove.conversion.base import Conversion, SharedFrames

LARGE = 128 << 10
"""Size above which a message is converted in a thread [bytes of JSON]: maps, images, clouds of points."""


class Feed:
    """Converts the messages of one channel.

    While a large message is converted, the newest one waits, and those between are dropped.

    Parameters
    ----------
    conversion : Conversion
    frames : SharedFrames
    send : callable
        Called with each converted message.
    fail : callable
        Called with the error of a message that cannot be converted.
    """

    def __init__(
        self,
        conversion: Conversion,
        frames: SharedFrames,
        send: Callable[[bytes], None],
        fail: Callable[[PPaaSError], None],
    ) -> None:
        self._convert = conversion.convert
        self._frames = frames
        self._send = send
        self._fail = fail
        self._waiting: bytes | None = None
        self._task: asyncio.Task[None] | None = None

    def take(self, payload: bytes) -> None:
        """Take a message of the topic, as JSON."""
        if self._task is not None or len(payload) > LARGE:
            self._waiting = payload
            if self._task is None:
                self._task = asyncio.create_task(self._convert_waiting())
            return
        try:
            self._send(self._convert(payload, self._frames))
        except PPaaSError as error:
            self._fail(error)

    async def _convert_waiting(self) -> None:
        try:
            while self._waiting is not None:
                payload, self._waiting = self._waiting, None
                try:
                    self._send(await asyncio.to_thread(self._convert, payload, self._frames))
                except PPaaSError as error:
                    self._fail(error)
        finally:
            self._task = None

    def close(self) -> None:
        """Convert no further message."""
        self._waiting = None
        if self._task is not None:
            self._task.cancel()
