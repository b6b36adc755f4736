"""Messages of one client that wait because of ``throttle_rate``, and the timer that sends them."""

import asyncio
from collections.abc import Callable

from ppaas.clock import monotonic
from ppaas.wire.rosbridge import RosbridgeSession


class DelayedMessages:
    """Sends the messages that a client's subscriptions delay.

    Parameters
    ----------
    wire : RosbridgeSession
        Has the messages.
    put : callable
        Called with the topic and the frame of each message that is due.
    guard : callable
        Calls a function, and ends the session if it fails.
    """

    def __init__(
        self,
        wire: RosbridgeSession,
        put: Callable[[str, bytes], None],
        guard: Callable[[Callable[[], None]], None],
    ) -> None:
        self._wire = wire
        self._put = put
        self._guard = guard
        # A loop returns a handle without a time for a timer that is due within half a millisecond (uvloop).
        self._at = float("inf")
        self._timer: asyncio.Handle | None = None

    def schedule(self) -> None:
        """Set the timer for the next message, if one waits."""
        due = self._wire.next_due()
        if due is None:
            return
        loop = asyncio.get_running_loop()
        at = loop.time() + max(due - monotonic(), 0.0)
        if at < self._at:
            self.stop()
            self._at, self._timer = at, loop.call_at(at, self._guard, self._send)

    def stop(self) -> None:
        """Stop the timer."""
        if self._timer is not None:
            self._timer.cancel()
        self._at, self._timer = float("inf"), None

    def _send(self) -> None:
        self.stop()
        for topic, frame in self._wire.due(monotonic()):
            self._put(topic, frame)
        self.schedule()
