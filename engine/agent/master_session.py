"""Whether a machine acts for a cloud now, and where its news go."""

from typing import Any

import msgspec

from engine.agent.master_lease import Lease
from engine.protocols.framing import FrameStream


class Standing:
    """Of one machine, through all its connections to masters.

    It acts from the master's welcome until the connection ends; where that is to another host, while its lease holds
    as well. A machine that does not act keeps no checkpoint and shows nothing to robots of others: what it carries may
    run elsewhere by then.

    Parameters
    ----------
    leased : bool
        The master is on another host, and answers beats.
    """

    def __init__(self, *, leased: bool) -> None:
        self._leased = leased
        self._stream: FrameStream[Any] | None = None
        self._welcome = False
        self.lease: Lease | None = None

    def begin(self, stream: FrameStream[Any]) -> None:
        """Note a connection to a master, which has not said yet what goes on."""
        self._stream = stream
        self._welcome = False
        self.lease = Lease() if self._leased else None

    def welcome(self) -> None:
        """Note that the master wants what is left."""
        self._welcome = True

    def lost(self) -> None:
        """Note that the connection has ended."""
        self._stream, self._welcome = None, False

    def tell(self, news: msgspec.Struct) -> None:
        """Send news to the master; without one, whatever comes next is told how things stand then."""
        if self._stream is not None:
            self._stream.write(news)

    def acts(self) -> bool:
        """Tell whether the machine acts for its cloud."""
        return self._welcome and (self.lease is None or self.lease.holds())
