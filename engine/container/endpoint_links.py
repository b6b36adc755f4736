"""Links of a container to the endpoints that carry sockets of its clients, beside the link to the master."""

import asyncio
import logging
import os
from pathlib import Path
from typing import Protocol

import msgspec

from engine.container.endpoint_link import Stream, dial
from engine.container.served_link import ServedLink
from engine.protocols import robot_link
from engine.protocols.address import UnixAddress, parse_address
from engine.protocols.framing import FrameStream
from engine.sessions.host import SessionHost
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)

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
