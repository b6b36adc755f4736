"""Service that the bridge serves in ROS 1."""

import asyncio
from collections.abc import Callable

from ppaas.errors import PPaaSError
from ppaas.wire.names import ros1_type
from ppaas.wire.ros import RosTypes
from ppaas.wire.ros.tcpros import answered, check_peer, server_header
from robots.bridges.core.notices import Notices
from robots.bridges.core.transport import Answer
from robots.bridges.ros1.peer import Peer

MAX_REQUEST = 1 << 20
"""Largest request [bytes]."""

MAX_CLIENTS = 64
"""Largest number of clients at once."""


class Service:
    """Server of one service.

    Parameters
    ----------
    types : RosTypes
        Types of messages.
    node, name, type_name : str
        Name of the bridge's node, name of the service, and its type, spelled as in ROS 2.
    answer : callable
        Answers a request.
    closed : callable
        Called with the service when it is closed.
    notices : Notices
        Log.
    """

    def __init__(
        self,
        types: RosTypes,
        node: str,
        name: str,
        type_name: str,
        answer: Answer,
        *,
        closed: "Callable[[Service], None]",
        notices: Notices,
    ) -> None:
        self.name, self.type = name, type_name
        self.peers: set[Peer] = set()
        self._types, self._answer, self._closed, self._notices = types, answer, closed, notices
        self._header = server_header(types, node, ros1_type(type_name))
        self._tasks: set[asyncio.Task[None]] = set()

    def close(self) -> None:
        """End the service."""
        self._closed(self)
        for task in self._tasks:
            task.cancel()
        for peer in list(self.peers):
            peer.close()

    def accept(self, peer: Peer, fields: dict[str, str]) -> None:
        """Take a client that has sent its header.

        Raises
        ------
        InvalidInput
            Its type is another one.
        """
        check_peer(self._types, fields, self._header["type"], service=True)
        if len(self.peers) >= MAX_CLIENTS:
            peer.abort()
            return
        persistent = fields.get("persistent") in ("1", "true", "True")
        peer.received = lambda peer, request: self._received(peer, request, persistent)
        peer.greeted(MAX_REQUEST)
        peer.send_header(self._header)
        self.peers.add(peer)
        peer.lost.add_done_callback(lambda _: self.peers.discard(peer))

    def _received(self, peer: Peer, request: bytes, persistent: bool) -> None:
        if len(self._tasks) >= MAX_CLIENTS:
            peer.send(answered(b"the bridge is busy: call again later", ok=False))
            return
        task = asyncio.create_task(self._respond(peer, request, persistent))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _respond(self, peer: Peer, request: bytes, persistent: bool) -> None:
        try:
            peer.send(answered(await self._answer(request)))
        except PPaaSError as error:
            self._notices.warn(f"a call of {self.name} by {peer.node} failed: {error}")
            peer.send(answered(str(error).encode(), ok=False))
        if not persistent:
            peer.close()
