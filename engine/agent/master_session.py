"""Master session: sends reports to the current master, and knows whether the machine acts for its cloud."""

from typing import Any

import msgspec

from engine.agent.master_lease import MasterLease
from engine.protocols import control_link
from engine.protocols.framing import FrameStream


class MasterSession:
    """Master session of one machine, over all its connections to masters.

    The machine acts for its cloud from the master's welcome until the connection ends, while its lease is valid. A
    machine that does not act stores no checkpoints and publishes nothing on the fabric, since its containers may have
    been replaced elsewhere.

    Parameters
    ----------
    remote : bool
        Whether the master is on another host, so that the network may be down.

    Attributes
    ----------
    lease : MasterLease
        Lease of the current connection.
    epoch : int
        Epoch of the latest master that this machine has followed.
    refused : bool
        Whether the master of the current connection was refused.
    """

    def __init__(self, *, remote: bool) -> None:
        self.remote = remote
        self._stream: FrameStream[Any] | None = None
        self._welcome = False
        self.lease = MasterLease()
        self.epoch = 0
        self.refused = False

    def begin(self, stream: FrameStream[Any]) -> None:
        """Begin a connection to a master that has not sent its welcome yet."""
        self._stream = stream
        self._welcome = self.refused = False
        self.lease = MasterLease()

    def welcome(self, epoch: int) -> bool:
        """Record the welcome of a master, for which the machine acts from now on; return whether it was accepted.

        A master of an earlier epoch than this machine has followed was replaced. It is notified, and refused.
        """
        if epoch < self.epoch:
            self.tell(control_link.Outranked(self.epoch))
            self.refused = True
            return False
        self.epoch, self._welcome = epoch, True
        return True

    def hang_up(self) -> None:
        """Abort the connection."""
        if self._stream is not None:
            self._stream.abort()

    def lost(self) -> None:
        """Record that the connection has ended."""
        self._stream, self._welcome = None, False

    def tell(self, news: msgspec.Struct) -> None:
        """Send a report to the master; dropped without one, as the next master gets the whole state on registration."""
        if self._stream is not None:
            self._stream.write(news)

    def acts(self) -> bool:
        """Return whether the machine acts for its cloud."""
        return self._welcome and self.lease.holds()

    def may_be_replaced(self) -> bool:
        """Return whether containers of this machine may have been replaced elsewhere.

        That is so while the machine does not act for its cloud, except while its master answers and nobody leads: a
        store that no master can use lets no other one take over, and this machine's containers are the only ones.
        """
        return not self.acts() and not (self._welcome and self.lease.nobody_leads())
