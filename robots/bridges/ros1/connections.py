"""TCPROS connections of a node: topics that it publishes and subscribes to, and services that it serves."""

import asyncio
import socket
import struct
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge, PPaaSError, Unavailable
from ppaas.wire.names import MAX_NAME, ros1_type
from ppaas.wire.ros import RosTypes
from ppaas.wire.ros.graph import Qos
from ppaas.wire.ros.tcpros import (
    MAX_HEADER,
    FrameReader,
    answered,
    check_peer,
    framed,
    pack_header,
    publisher_header,
    server_header,
    subscriber_header,
    unpack_header,
)
from ppaas.wire.ros.types import MAX_MESSAGE
from robots.bridges.core.notices import Notices
from robots.bridges.core.transport import Answer, Received
from robots.bridges.ros1.http import call

HEADER_TIMEOUT = 10.0
"""Time limit for the header of the other side [s]."""

KEEPALIVE = (5, 2, 3)
"""Silence before the first probe [s], time between probes [s], and their number: 11 s until a dead peer is noticed."""

WRITE_BUFFER, UNSENT = 64 << 10, 16 << 10
"""Bytes that wait in this process and in the kernel; the queue, which may drop messages, holds the rest [bytes]."""

BACKOFF = 4
"""Doublings of the time between two attempts of TCP to send, from 0.2 s on, after which a peer counts as stalled."""

DEPTH = 10
"""Length of a queue, where nothing else is set."""


class NodeConnection(asyncio.Protocol):
    """Connection to another node.

    Parameters
    ----------
    received : callable
        Called with this peer and each frame; the first one is the header of the other side.

    Attributes
    ----------
    received : callable
        As above; it is replaced when the header has been read.
    node, topic : str
        Name of the node, and topic or service of the connection; empty until its header has been read.
    limit : int
        Largest frame that is read [bytes].
    lost : Future of None
        Set when the connection is lost.
    """

    def __init__(self, received: "Callable[[NodeConnection, bytes], None]") -> None:
        self.received = received
        self.node = self.topic = ""
        self.limit = MAX_HEADER
        self.bytes_carried = self.frames_carried = 0
        loop = asyncio.get_running_loop()
        self.lost: asyncio.Future[None] = loop.create_future()
        self._reader = FrameReader()
        self._queue: deque[bytes] = deque(maxlen=DEPTH)
        self._paused = False
        self._transport: asyncio.Transport | None = None
        self._timer = loop.call_later(HEADER_TIMEOUT, self.abort)

    def greeted(self, limit: int, depth: int = DEPTH) -> None:
        """Go on from the header to messages of at most ``limit`` bytes, and a queue of ``depth`` messages."""
        self._timer.cancel()
        self.limit = limit
        self._queue = deque(self._queue, maxlen=max(depth, 1))

    def send_header(self, fields: dict[str, str]) -> None:
        """Send a header."""
        self._write(framed(pack_header(fields)))

    def send(self, data: bytes) -> None:
        """Send a message with its length in front; if the other side does not read, the oldest one is dropped."""
        if self._paused:
            self._queue.append(data)
        else:
            self._write(data)

    @property
    def closing(self) -> bool:
        """True if the connection is closed, or about to be."""
        return self._transport is None or self._transport.is_closing()

    @property
    def stalled(self) -> bool:
        """True if TCP has nearly given up sending unconfirmed bytes again, as after an outage; known on Linux only."""
        if self.closing or self._transport is None or not hasattr(socket, "TCP_INFO"):
            return False
        info = self._transport.get_extra_info("socket").getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 8)
        return bool(info[4] >= BACKOFF)  # tcpi_backoff of `struct tcp_info`

    def reset(self) -> None:
        """Close the connection by a reset of TCP: the other side notices it at once, and reconnects."""
        if self._transport is not None:
            at_once = struct.pack("ii", 1, 0)
            self._transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, at_once)
        self.abort()

    def close(self) -> None:
        """Close the connection once its write buffer is empty."""
        self._timer.cancel()
        if self._transport is not None:
            self._transport.close()

    def abort(self) -> None:
        """Close the connection at once."""
        self._timer.cancel()
        if self._transport is not None:
            self._transport.abort()

    def _write(self, data: bytes) -> None:
        if self._transport is None or self._transport.is_closing():
            return
        self.bytes_carried += len(data)
        self.frames_carried += 1
        self._transport.write(data)

    # -- callbacks of asyncio ------------------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take the connection."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        transport.set_write_buffer_limits(high=WRITE_BUFFER)
        connected = transport.get_extra_info("socket")
        connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connected.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT)
        if hasattr(socket, "TCP_KEEPIDLE"):  # Linux
            for option, value in zip(
                (socket.TCP_KEEPIDLE, socket.TCP_KEEPINTVL, socket.TCP_KEEPCNT), KEEPALIVE, strict=True
            ):
                connected.setsockopt(socket.IPPROTO_TCP, option, value)

    def data_received(self, data: bytes) -> None:
        """Hand on the frames that are complete."""
        self._reader.feed(data)
        try:
            while not self.closing and (frame := self._reader.take(self.limit)) is not None:
                self.bytes_carried += len(frame)
                self.frames_carried += 1
                self.received(self, frame)
        except MessageTooLarge:
            self.abort()

    def pause_writing(self) -> None:
        """Queue what follows."""
        self._paused = True

    def resume_writing(self) -> None:
        """Send what was queued."""
        self._paused = False
        while self._queue and not self._paused:
            self._write(self._queue.popleft())

    def connection_lost(self, error: Exception | None) -> None:
        """Set ``lost``."""
        self._timer.cancel()
        self._queue.clear()
        if not self.lost.done():
            self.lost.set_result(None)


# -- topic that the bridge publishes in ROS 1 --------------------------------------------------------------------------

MAX_SUBSCRIBERS = 64
"""Largest number of subscribers of a topic."""

MAX_ANSWER = 1024
"""Largest frame that a subscriber may send, which is ignored [bytes]."""


class Ros1Publication:
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
        closed: "Callable[[Ros1Publication], None]",
        notices: Notices,
    ) -> None:
        self.name, self.type = name, type_name
        self.peers: list[NodeConnection] = []
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

    def accept(self, peer: NodeConnection, fields: dict[str, str]) -> None:
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

    def _lost(self, peer: NodeConnection) -> None:
        self.peers.remove(peer)
        self._changed()


# -- topic that the bridge subscribes to in ROS 1 ----------------------------------------------------------------------

FIRST_RETRY, LAST_RETRY = 0.25, 8.0
"""Shortest and longest time before a lost publisher is asked again [s]."""

MAX_PUBLISHERS = 64
"""Largest number of publishers of a topic."""


class Ros1Subscription:
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
        closed: "Callable[[Ros1Subscription], None]",
        notices: Notices,
    ) -> None:
        self.name, self.type = name, type_name
        self.peers: dict[str, NodeConnection] = {}
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

    async def _listen(self, uri: str, peer: NodeConnection) -> None:
        self.peers[uri], self.fault = peer, ""
        self._changed()
        try:
            await peer.lost
        finally:
            del self.peers[uri]
            peer.abort()
            self._changed()

    async def _connect(self, uri: str) -> NodeConnection:
        host, port = _tcpros(await call(uri, "requestTopic", self._node, self.name, [["TCPROS"]]))
        loop = asyncio.get_running_loop()
        greeted: asyncio.Future[None] = loop.create_future()
        peer = NodeConnection(lambda peer, frame: self._greet(peer, frame, greeted))
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

    def _greet(self, peer: NodeConnection, frame: bytes, greeted: "asyncio.Future[None]") -> None:
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

    def _message(self, _peer: NodeConnection, frame: bytes) -> None:
        self._received(frame)


def _tcpros(value: Any) -> tuple[str, int]:
    """Return host and port in a response to ``requestTopic``."""
    if not isinstance(value, list) or [type(one) for one in value] != [str, str, int] or value[0] != "TCPROS":
        raise MalformedMessage("the node offers no TCPROS")
    if not 0 < value[2] < 1 << 16:
        raise MalformedMessage(f"the node publishes at a port that cannot be: {value[2]}")
    return value[1], value[2]


# -- service that the bridge serves in ROS 1 ---------------------------------------------------------------------------

MAX_REQUEST = 1 << 20
"""Largest request [bytes]."""

MAX_CLIENTS = 64
"""Largest number of clients at once."""


class Ros1Service:
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
        closed: "Callable[[Ros1Service], None]",
        notices: Notices,
    ) -> None:
        self.name, self.type = name, type_name
        self.peers: set[NodeConnection] = set()
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

    def accept(self, peer: NodeConnection, fields: dict[str, str]) -> None:
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

    def _received(self, peer: NodeConnection, request: bytes, persistent: bool) -> None:
        if len(self._tasks) >= MAX_CLIENTS:
            peer.send(answered(b"the bridge is busy: call again later", ok=False))
            return
        task = asyncio.create_task(self._respond(peer, request, persistent))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _respond(self, peer: NodeConnection, request: bytes, persistent: bool) -> None:
        try:
            peer.send(answered(await self._answer(request)))
        except PPaaSError as error:
            self._notices.warn(f"a call of {self.name} by {peer.node} failed: {error}")
            peer.send(answered(str(error).encode(), ok=False))
        if not persistent:
            peer.close()
