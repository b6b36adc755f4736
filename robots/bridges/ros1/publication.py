"""Topic that the bridge publishes in ROS 1."""

from collections.abc import Callable

from ppaas.errors import InvalidInput
from ppaas.wire.names import ros1_type
from ppaas.wire.ros import RosTypes
from ppaas.wire.ros.graph import Qos
from ppaas.wire.ros.tcpros import check_peer, framed, publisher_header
from robots.bridges.core.notices import Notices
from robots.bridges.ros1.peer import Peer

MAX_SUBSCRIBERS = 64
"""Largest number of subscribers of a topic."""

MAX_ANSWER = 1024
"""Largest frame that a subscriber may send, which is ignored [bytes]."""


class Publication:
    """Publisher; the last message of a latched one is kept for late subscribers.

    Parameters
    ----------
    types : RosTypes
        Types of messages.
    node, name, type_name : str
        Name of the bridge's node, name of the topic, and type of its messages, spelled as in ROS 2.
    qos : Qos
        Whether it is latched, and the length of each subscriber's queue.
    changed : callable
        Called when a subscriber has come or gone.
    closed : callable
        Called with the publication when it is closed.
    notices : Notices
        Log.
    """

    def __init__(
        self,
        types: RosTypes,
        node: str,
        name: str,
        type_name: str,
        qos: Qos,
        *,
        changed: Callable[[], None],
        closed: "Callable[[Publication], None]",
        notices: Notices,
    ) -> None:
        self.name, self.type = name, type_name
        self.peers: list[Peer] = []
        self._types, self._qos, self._notices = types, qos, notices
        self._changed, self._closed = changed, closed
        self._header = publisher_header(types, node, name, ros1_type(type_name), latching=qos.latched)
        self._last: bytes | None = None

    def publish(self, data: bytes) -> None:
        """Publish a message."""
        frame = framed(data)
        if self._qos.latched:
            self._last = frame
        for peer in self.peers:
            peer.send(frame)

    def close(self) -> None:
        """End the topic."""
        self._closed(self)
        for peer in list(self.peers):
            peer.close()

    def accept(self, peer: Peer, fields: dict[str, str]) -> None:
        """Take a subscriber that has sent its header; one with another type gets an error.

        Raises
        ------
        InvalidInput
            Its type is another one, or there are too many subscribers.
        """
        try:
            check_peer(self._types, fields, self._header["type"])
        except InvalidInput as error:
            self._notices.warn(f"{peer.node} does not get {self.name}: {error}")
            raise
        if len(self.peers) >= MAX_SUBSCRIBERS:
            raise InvalidInput(f"{self.name} has {MAX_SUBSCRIBERS} subscribers already")
        peer.received = lambda _peer, _frame: None
        peer.greeted(MAX_ANSWER, self._qos.depth)
        peer.send_header(self._header)
        if self._last is not None:
            peer.send(self._last)
        self.peers.append(peer)
        peer.lost.add_done_callback(lambda _: self._lost(peer))
        self._changed()

    def _lost(self, peer: Peer) -> None:
        self.peers.remove(peer)
        self._changed()
