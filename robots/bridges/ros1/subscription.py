"""Topic that the bridge subscribes to in ROS 1: a connection to each publisher, made again when it is lost."""

import asyncio
from collections.abc import Callable, Iterable
from typing import Any

from ppaas.errors import InvalidInput, MalformedMessage, PPaaSError, Unavailable
from ppaas.wire.names import MAX_NAME, ros1_type
from ppaas.wire.ros import RosTypes
from ppaas.wire.ros.tcpros import check_peer, subscriber_header, unpack_header
from ppaas.wire.ros.types import MAX_MESSAGE
from robots.bridges.core.notices import Notices
from robots.bridges.core.transport import Received
from robots.bridges.ros1.http import call
from robots.bridges.ros1.peer import HEADER_TIMEOUT, Peer

FIRST_RETRY, LAST_RETRY = 0.25, 8.0
"""Shortest and longest time before a lost publisher is asked again [s]."""

MAX_PUBLISHERS = 64
"""Largest number of publishers of a topic."""


class Subscription:
    """Subscription to a topic.

    The connection to a publisher that the master does not name any more is kept for as long as it lasts: a master that
    was restarted knows nobody, and nodes of ROS 1 go on without it.

    Parameters
    ----------
    types : RosTypes
        Types of messages.
    node, name, type_name : str
        Name of the bridge's node, name of the topic, and type of its messages, spelled as in ROS 2.
    received : callable
        Called with each message.
    changed : callable
        Called when a publisher has come or gone.
    closed : callable
        Called with the subscription when it is closed.
    notices : Notices
        Log.

    Attributes
    ----------
    peers : dict
        Connected publishers, by the URIs of their nodes.
    fault : str
        Why no publisher is connected; empty if one is, or none is known.
    """

    def __init__(
        self,
        types: RosTypes,
        node: str,
        name: str,
        type_name: str,
        received: Received,
        *,
        changed: Callable[[], None],
        closed: "Callable[[Subscription], None]",
        notices: Notices,
    ) -> None:
        self.name, self.type = name, type_name
        self.peers: dict[str, Peer] = {}
        self.fault = ""
        self._types, self._node, self._received, self._notices = types, node, received, notices
        self._changed, self._closed = changed, closed
        self._named: frozenset[str] = frozenset()
        self._following: dict[str, asyncio.Task[None]] = {}

    def update(self, uris: Iterable[str]) -> None:
        """Follow the publishers that the master names, by the URIs of their nodes."""
        self._named = frozenset(sorted(uris)[:MAX_PUBLISHERS])
        for uri in self._named - self._following.keys():
            self._following[uri] = asyncio.create_task(self._follow(uri))

    def close(self) -> None:
        """End the subscription."""
        self._closed(self)
        self._named = frozenset()
        for task in self._following.values():
            task.cancel()

    async def _follow(self, uri: str) -> None:
        try:
            await self._keep_connected(uri)
        finally:
            del self._following[uri]

    async def _keep_connected(self, uri: str) -> None:
        delay = FIRST_RETRY
        while uri in self._named:
            try:
                peer = await self._connect(uri)
            except PPaaSError as error:
                self.fault = f"{self.name} is not received: {error}"
                self._notices.warn(self.fault)
                await asyncio.sleep(delay)
                delay = min(2 * delay, LAST_RETRY)
                continue
            delay = FIRST_RETRY
            await self._listen(uri, peer)
            await asyncio.sleep(delay)

    async def _listen(self, uri: str, peer: Peer) -> None:
        self.peers[uri], self.fault = peer, ""
        self._changed()
        try:
            await peer.lost
        finally:
            del self.peers[uri]
            peer.abort()
            self._changed()

    async def _connect(self, uri: str) -> Peer:
        host, port = _tcpros(await call(uri, "requestTopic", self._node, self.name, [["TCPROS"]]))
        loop = asyncio.get_running_loop()
        greeted: asyncio.Future[None] = loop.create_future()
        peer = Peer(lambda peer, frame: self._greet(peer, frame, greeted))
        try:
            async with asyncio.timeout(HEADER_TIMEOUT):
                await loop.create_connection(lambda: peer, host, port)
                peer.send_header(subscriber_header(self._types, self._node, self.name, ros1_type(self.type)))
                await asyncio.wait({greeted, peer.lost}, return_when=asyncio.FIRST_COMPLETED)
            if not greeted.done():
                raise Unavailable(f"{uri} closed the connection before its header")
            greeted.result()
        except (OSError, TimeoutError, UnicodeError) as error:  # the last one of hosts that no name can have
            peer.abort()
            raise Unavailable(
                f"{uri} publishes at {host}:{port}, which does not answer ({error or 'no header in time'}): "
                "set ROS_IP of the robot to an address that this computer reaches"
            ) from error
        except BaseException:
            peer.abort()
            raise
        peer.node = peer.node or uri
        return peer

    def _greet(self, peer: Peer, frame: bytes, greeted: "asyncio.Future[None]") -> None:
        """Take the header of a publisher; messages may be right behind it."""
        try:
            fields = unpack_header(frame)
            check_peer(self._types, fields, ros1_type(self.type))
        except InvalidInput as error:
            peer.abort()
            if not greeted.done():
                greeted.set_exception(error)
            return
        peer.node, peer.topic = fields.get("callerid", "")[:MAX_NAME], self.name
        peer.received = self._message
        peer.greeted(MAX_MESSAGE)
        if not greeted.done():
            greeted.set_result(None)

    def _message(self, _peer: Peer, frame: bytes) -> None:
        self._received(frame)


def _tcpros(value: Any) -> tuple[str, int]:
    """Return host and port in a response to ``requestTopic``."""
    if not isinstance(value, list) or [type(one) for one in value] != [str, str, int] or value[0] != "TCPROS":
        raise MalformedMessage("the node offers no TCPROS")
    if not 0 < value[2] < 1 << 16:
        raise MalformedMessage(f"the node publishes at a port that cannot be: {value[2]}")
    return value[1], value[2]
