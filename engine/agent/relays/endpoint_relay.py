"""Endpoint relay: connects a machine's containers with endpoints that they cannot dial themselves.

A container in Docker sees no other sockets of its host, and one on another host than the endpoint neither holds the key
of its machine nor needs a network. It dials the relay, and writes a line with the addresses of the endpoint: that for
the endpoint's own host, and that for other hosts.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from pathlib import Path

from engine.agent.relays.robot_link_relay import carry_both_ways
from engine.protocols.address import UnixAddress, parse_address
from engine.protocols.endpoint_sockets import is_endpoint_socket
from engine.protocols.sockets import Streams, listen
from ppaas.errors import InvalidInput, NotPermitted, PPaaSError

logger = logging.getLogger(__name__)

LINE_TIMEOUT = 5.0
"""Time within which a connected container must write the addresses [s]."""


class EndpointRelay:
    """Forwards bytes between containers and endpoints, without decoding them.

    Parameters
    ----------
    path : Path
        Path of the Unix socket; only the user of this process may connect to it.
    dial : callable
        Connects to an endpoint at an address; raises ``Unavailable`` if it does not answer.
    is_far : bool
        Whether the endpoints are on other hosts.
    """

    def __init__(self, path: Path, dial: Callable[[str], Awaitable[Streams]], *, is_far: bool) -> None:
        self.path = path
        self._dial = dial
        self._is_far = is_far
        self._server: asyncio.Server | None = None
        self._open: set[asyncio.StreamWriter] = set()

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._server = await listen(UnixAddress(self.path), self._connected)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._open.add(writer)
        try:
            async with asyncio.timeout(LINE_TIMEOUT):
                line = await reader.readline()
            far_reader, far_writer = await self._dial(self._chosen(line))
        except (PPaaSError, TimeoutError, ValueError) as error:
            logger.warning("a container could not connect to an endpoint: %s", str(error) or "it named none in time")
            self._open.discard(writer)
            writer.close()
            return
        self._open.add(far_writer)
        try:
            await carry_both_ways((reader, writer), (far_reader, far_writer))
        finally:
            self._open -= {writer, far_writer}

    def _chosen(self, line: bytes) -> str:
        """Return the address to dial.

        Raises
        ------
        InvalidInput
            The line is none of a container.
        NotPermitted
            The address is not that of an endpoint.
        """
        near, _, far = line.decode().strip().partition(" ")
        if self._is_far:
            if not far:
                raise InvalidInput(
                    "the endpoint has no address for other hosts: start the cloud with --listen-machines"
                )
            return far
        address = parse_address(near)
        if not isinstance(address, UnixAddress) or not is_endpoint_socket(address.path, self.path.parent):
            raise NotPermitted(f"{near[:128]!r} is not the address of an endpoint of this host")
        return near

    async def close(self) -> None:
        """Stop listening, and close all connections."""
        if self._server is not None:
            self._server.close()
        for writer in tuple(self._open):
            writer.transport.abort()
        self.path.unlink(missing_ok=True)
