"""Links of a container: to the master or its endpoint, and to the endpoints that carry sockets of its clients.

The container dials until its machine stops it, and sends its hello to the endpoint that answers. It dials the first at
once when its machine notifies it that an endpoint listens, and otherwise with increasing delays.
"""

import asyncio
import contextlib
import logging
import os
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import msgspec

from engine.links.frame_writer import FrameWriter
from engine.protocols import robot_link
from engine.protocols.address import UnixAddress, parse_address
from engine.protocols.framing import FrameStream
from engine.protocols.robot_link import NodeInfo, ServiceInfo, TopicInfo
from engine.sessions.host import SessionHost
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)

RETRIES = (0.1, 0.2, 0.4, 0.8)
"""Delays before the first, second … attempt [s]; the last is repeated."""

STEADY = 5.0
"""Duration of a connection after which the delays start from the first again [s]."""

Stream = FrameStream[robot_link.ToContainer]


async def dial(path: str) -> Stream:
    """Dial the endpoint's Unix socket; ``OSError`` if it does not answer."""
    return FrameStream(*await asyncio.open_unix_connection(path), robot_link.ToContainer)


class EndpointLink:
    """Connection of a container to its endpoint, replaced by a new one when it is lost.

    Parameters
    ----------
    path : str
        Path of the Unix socket of the endpoint, or of the relay to it.
    stream : FrameStream
        The first connection.
    """

    def __init__(self, path: str, stream: Stream) -> None:
        self._path = path
        self.stream = stream
        self._came = asyncio.Event()
        self.is_up = True

    def came(self) -> None:
        """Dial at once: an endpoint listens again, and robots wait for this container."""
        self._came.set()

    def write(self, frame: msgspec.Struct) -> None:
        """Queue a frame; it is lost while no endpoint is connected."""
        self.stream.write(frame)

    @property
    def waiting(self) -> int:
        """Number of written bytes that are still queued for the endpoint."""
        return self.stream.waiting

    async def serve(
        self,
        take: Callable[[robot_link.ToContainer], bool],
        hello: Callable[[], robot_link.Hello],
        lost: Callable[[], None],
    ) -> None:
        """Pass each frame to ``take`` until it returns false; after a lost connection, dial again and send the hello.

        Parameters
        ----------
        take : callable
            Handles a frame; returns false if it was the last.
        hello : callable
            Returns the first frame for the next endpoint.
        lost : callable
            Called when the connection to the endpoint is lost.
        """
        loop, tries = asyncio.get_running_loop(), 0
        while True:
            began = loop.time()
            if await self.stream.each(take):
                return
            self.is_up = False
            lost()
            tries = 0 if loop.time() - began > STEADY else tries
            tries = await self._dial_again(tries)
            self.stream.write(hello())

    async def _dial_again(self, tries: int) -> int:
        await self.stream.close()
        while True:
            await self._wait(RETRIES[min(tries, len(RETRIES) - 1)])
            tries += 1
            try:
                self.stream = await dial(self._path)
            except OSError as error:
                logger.debug("the endpoint is not reachable yet: %s", error)
            else:
                self.is_up = True
                return tries

    async def _wait(self, seconds: float) -> None:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await self._came.wait()
        self._came.clear()

    async def close(self) -> None:
        """Close the connection."""
        await self.stream.close()


MAX_WAITING = 1 << 20
"""Bytes queued for a slow endpoint above which messages are dropped whose topic is neither latched nor lasting, or is
repeated."""

FarEnd = FrameWriter[robot_link.FromContainer]
"""The other end of a link."""


class ServedLink:
    """A link with its subscriptions, which listens to the clone.

    Parameters
    ----------
    end : FarEnd
        Its other end.
    applied : int
        Sequence number of the last message of this link that the clone has processed.

    Attributes
    ----------
    wanted : set of str
        Topics that it is subscribed to.
    """

    def __init__(self, end: FarEnd, applied: int = 0) -> None:
        self.end = end
        self.applied = applied
        self.wanted: set[str] = set()

    @property
    def is_slow(self) -> bool:
        """Whether messages that may be lost are to be dropped for it."""
        return self.end.waiting > MAX_WAITING

    def wants(self, topic: str) -> bool:
        """Return whether it is subscribed to a topic."""
        return topic in self.wanted

    def published(self, topic: str, payload: bytes, client: int = 0) -> None:
        """Send a message; with a client, a latched one for that client alone."""
        self.end.write(robot_link.Published(topic, payload, client or None))

    def map_replaced(self) -> None:
        """Send the news that only changes of the map were published."""
        self.end.write(robot_link.MapReplaced())

    def topic_added(self, topic: TopicInfo, node: str) -> None:
        """Send the news of a topic that a node has begun to publish."""
        self.end.write(robot_link.TopicAdded(topic, node))

    def topic_removed(self, topic: str) -> None:
        """Send the news that a topic was removed."""
        self.end.write(robot_link.TopicRemoved(topic))

    def nodes_changed(self, services: list[ServiceInfo], nodes: list[NodeInfo]) -> None:
        """Send the current services and nodes."""
        self.end.write(robot_link.NodesChanged(services, nodes))

    def acknowledged(self, sequence: int) -> None:
        """Send the news that all messages up to a number are in a stored checkpoint."""
        self.end.write(robot_link.Ack(sequence))


RETRY = 0.25
"""Time between two attempts to dial an endpoint [s]."""

ATTEMPTS = 120
"""Number of attempts in a row after which an endpoint counts as gone."""


class Serving(Protocol):
    """The container, as its links see it."""

    def hello(self, pid: int, endpoint: robot_link.DialEndpoint | None = None) -> robot_link.Hello:
        """Return the first frame for the link to the master, or to an endpoint."""
        ...

    def take(self, link: ServedLink, frame: robot_link.ToContainer) -> bool:
        """Handle a frame of a link; return false if it is the last."""
        ...

    def add_link(self, link: ServedLink) -> None:
        """Serve a link, too."""
        ...

    def drop_link(self, link: ServedLink) -> None:
        """Stop serving a link."""
        ...


class _End:
    """Writing end of the link to one endpoint; frames are lost while it is not connected."""

    def __init__(self) -> None:
        self.stream: Stream | None = None

    def write(self, frame: msgspec.Struct) -> None:
        if self.stream is not None:
            self.stream.write(frame)

    @property
    def waiting(self) -> int:
        return 0 if self.stream is None else self.stream.waiting


class EndpointLinks:
    """Dials endpoints, and again those whose link is lost.

    Parameters
    ----------
    container : Serving
        The container.
    sessions : SessionHost, optional
        Sessions of the clients of a clone.
    relay : Path
        Socket by which the machine relays to endpoints that the container cannot dial itself.
    machine : str
        Name of the machine.
    """

    def __init__(self, container: Serving, sessions: SessionHost | None, relay: Path, machine: str) -> None:
        self._container = container
        self._sessions = sessions
        self._relay = relay
        self._machine = machine
        self._dialled: dict[str, asyncio.Task[None]] = {}
        self._orders: dict[str, robot_link.DialEndpoint] = {}
        self._up: set[str] = set()

    @property
    def any_up(self) -> bool:
        """True while an endpoint is connected."""
        return bool(self._up)

    def dial(self, order: robot_link.DialEndpoint) -> None:
        """Dial an endpoint, unless it is dialled already."""
        if order != self._orders.get(order.endpoint) or self._dialled[order.endpoint].done():
            self.leave(order.endpoint)
            self._orders[order.endpoint] = order
            self._dialled[order.endpoint] = asyncio.create_task(self._serve(order))

    def leave(self, endpoint: str) -> None:
        """Dial an endpoint no more, and close its link."""
        self._orders.pop(endpoint, None)
        running = self._dialled.pop(endpoint, None)
        if running is not None:
            running.cancel()

    async def close(self) -> None:
        """Close all links."""
        running = tuple(self._dialled.values())
        for endpoint in tuple(self._dialled):
            self.leave(endpoint)
        await asyncio.gather(*running, return_exceptions=True)

    async def _serve(self, order: robot_link.DialEndpoint) -> None:
        end = _End()
        while (stream := await self._dial(order)) is not None:
            end.stream = stream
            try:
                if await self._serve_stream(order, end, stream):
                    return
            except PPaaSError as error:
                logger.warning("the link to endpoint %s is closed and dialled again: %s", order.endpoint, error)
            finally:
                end.stream = None
                await stream.close()
            await asyncio.sleep(RETRY)
        logger.warning("endpoint %s does not answer any more", order.endpoint)

    async def _serve_stream(self, order: robot_link.DialEndpoint, end: _End, stream: Stream) -> bool:
        """Serve one connection; return whether the endpoint ended it."""
        link = ServedLink(end)
        stream.write(self._container.hello(os.getpid(), order))
        self._container.add_link(link)
        self._up.add(order.endpoint)
        if self._sessions is not None:
            self._sessions.link_up(end)
        try:
            return await stream.each(lambda frame: self._take(link, frame))
        finally:
            self._up.discard(order.endpoint)
            if self._sessions is not None:
                self._sessions.link_lost(end)
            self._container.drop_link(link)

    def _take(self, link: ServedLink, frame: robot_link.ToContainer) -> bool:
        if isinstance(frame, robot_link.Shutdown):
            return False
        return self._container.take(link, frame)

    async def _dial(self, order: robot_link.DialEndpoint) -> Stream | None:
        """Dial an endpoint until it answers; return None if it does not for a while."""
        for _ in range(ATTEMPTS):
            try:
                return await self._dial_once(order)
            except OSError as error:
                logger.debug("an endpoint is not reachable yet: %s", error)
            await asyncio.sleep(RETRY)
        return None

    async def _dial_once(self, order: robot_link.DialEndpoint) -> Stream:
        address = parse_address(order.at.near)
        if order.at.machine == self._machine and isinstance(address, UnixAddress) and address.path.exists():
            return await dial(str(address.path))
        stream = await asyncio.open_unix_connection(self._relay)
        stream[1].write(msgspec.json.encode(order.at) + b"\n")
        return FrameStream(*stream, robot_link.ToContainer)
