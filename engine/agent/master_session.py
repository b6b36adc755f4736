"""Master session: sends reports to the current master, and knows whether the machine acts for its cloud."""

from typing import Any

import msgspec

from engine.agent.master_lease import MasterLease
from engine.protocols.framing import FrameStream


class MasterSession:
    """Master session of one machine, over all its connections to masters.

    The machine acts for its cloud from the master's welcome until the connection ends. If the master is on another
    host, its lease must be valid as well. A machine that does not act stores no checkpoints and publishes nothing on
    the fabric, since its containers may have been replaced elsewhere.

    Parameters
    ----------
    leased : bool
        Whether the master is on another host, and answers heartbeats.
    """

    def __init__(self, *, leased: bool) -> None:
        self._leased = leased
        self._stream: FrameStream[Any] | None = None
        self._welcome = False
        self.lease: MasterLease | None = None

    def begin(self, stream: FrameStream[Any]) -> None:
        """Begin a connection to a master that has not sent its welcome yet."""
        self._stream = stream
        self._welcome = False
        self.lease = MasterLease() if self._leased else None

    def welcome(self) -> None:
        """Record the master's welcome: from now on the machine acts for it."""
        self._welcome = True

    def lost(self) -> None:
        """Record that the connection has ended."""
        self._stream, self._welcome = None, False

    def tell(self, news: msgspec.Struct) -> None:
        """Send a report to the master; dropped without one, as the next master gets the whole state on registration."""
        if self._stream is not None:
            self._stream.write(news)

    def acts(self) -> bool:
        """Return whether the machine acts for its cloud."""
        return self._welcome and (self.lease is None or self.lease.holds())
