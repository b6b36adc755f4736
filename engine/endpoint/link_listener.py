"""Listener of an endpoint for containers: each names its place, and knows the secret of it."""

import asyncio
import logging
import secrets
import ssl
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from engine.protocols import robot_link
from engine.protocols.address import TlsAddress, UnixAddress
from engine.protocols.framing import FrameStream
from engine.protocols.pending_handshakes import is_same
from engine.protocols.place_secret import place_secret
from engine.protocols.sockets import listen
from engine.protocols.unproven_peers import UnprovenPeers
from engine.service.links.place_link import PlaceLink
from ppaas.errors import NotPermitted, PPaaSError

logger = logging.getLogger(__name__)

HELLO_TIMEOUT = 5.0
"""Time within which a connected container must send its first frame [s]."""


class MachineAccess(NamedTuple):
    """Access for containers of other hosts: the address to listen at, and the TLS settings."""

    address: TlsAddress
    context: ssl.SSLContext


class LinkListener:
    """Passes the link of each container to its place.

    Parameters
    ----------
    path : Path
        Path of the Unix socket; only this user may connect to it.
    machines : MachineAccess, optional
        Access for containers of other hosts; None for none.
    place : callable
        Returns the link of a place by name.

    Attributes
    ----------
    secret : str
        Secret from which those of the places are derived.
    far_address : str
        Address that containers of other hosts dial; empty if there is none.
    """

    def __init__(self, path: Path, place: Callable[[str], PlaceLink], machines: MachineAccess | None = None) -> None:
        self.path = path
        self.far_address = ""
        self.secret = secrets.token_urlsafe(24)
        self._place = place
        self._machines = machines
        self._servers: list[asyncio.Server] = []
        self._streams: set[FrameStream[robot_link.FromContainer]] = set()
        self._unproven = UnprovenPeers("endpoint, links of containers")

    @property
    def address(self) -> str:
        """Address that containers dial."""
        return str(UnixAddress(self.path))

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._servers.append(await listen(UnixAddress(self.path), self._connected))
        if self._machines is not None:
            address, context = self._machines.address, self._machines.context
            server = await listen(address._replace(port=0), self._connected_from_afar, context)
            self._servers.append(server)
            self.far_address = str(address._replace(port=server.sockets[0].getsockname()[1]))

    async def _serve(self, hello: robot_link.Hello, stream: FrameStream[robot_link.FromContainer]) -> None:
        """Serve a container, unless the place has a later one: a machine that was cut off may still run the former."""
        place = self._place(hello.place)
        if hello.generation < place.generation:
            logger.info("container %s was replaced, and is not served any more", hello.container)
            stream.write(robot_link.Shutdown())
            return
        place.generation = hello.generation
        await place.serve(hello, stream)

    def _is_of_place(self, hello: robot_link.Hello) -> bool:
        return is_same(place_secret(self.secret, hello.place, hello.generation), hello.secret)

    async def _connected_from_afar(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve a container of another host, whose machine has a certificate of this cloud."""
        if writer.get_extra_info("ssl_object").getpeercert(binary_form=True) is None:
            logger.warning("closed a link of a container whose machine has no certificate")
            writer.close()
            return
        await self._connected(reader, writer)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        stream: FrameStream[robot_link.FromContainer] = FrameStream(reader, writer, robot_link.FromContainer)
        self._streams.add(stream)
        self._unproven.came(stream)
        try:
            async with asyncio.timeout(HELLO_TIMEOUT):
                hello = await stream.receive()
            if not isinstance(hello, robot_link.Hello) or not self._is_of_place(hello):
                raise NotPermitted("a container without the secret of its place dialled this endpoint")
            self._unproven.proved(stream)
            await self._serve(hello, stream)
        except (PPaaSError, TimeoutError) as error:
            logger.warning("closed a link of a container: %s", str(error) or "it sent no first frame in time")
        finally:
            self._unproven.proved(stream)
            self._streams.discard(stream)
            await stream.close()

    async def close(self) -> None:
        """Stop listening, and close all links."""
        for server in self._servers:
            server.close()
        await asyncio.gather(*(stream.close() for stream in self._streams))
        self.path.unlink(missing_ok=True)
