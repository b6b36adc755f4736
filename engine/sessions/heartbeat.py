"""Heartbeat: a topic of the endpoint by which a client knows that its connection is alive, whatever others publish.

Pages in browsers do not see the pings of a WebSocket, and a topic on which nothing is published looks like a connection
that is lost.
"""

import asyncio
from collections.abc import Callable

from ppaas.clock import epoch
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.wire.own_topics import HEARTBEAT

PERIOD = 1.0
"""Interval of the messages [s]."""


class Heartbeat:
    """Sends a client that subscribes to ``HEARTBEAT`` a message at once and then once a second.

    Parameters
    ----------
    publish : callable
        Called with the topic and a message as JSON.
    """

    def __init__(self, publish: Callable[[str, bytes], None]) -> None:
        self._publish = publish
        self._timer: asyncio.TimerHandle | None = None

    def start(self) -> None:
        """Send messages from now on."""
        if self._timer is None:
            self._beat()

    def stop(self) -> None:
        """Send no further messages."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _beat(self) -> None:
        self._timer = asyncio.get_running_loop().call_later(PERIOD, self._beat)
        self._publish(HEARTBEAT, encode(Header(stamp=Time.of(epoch()))))
