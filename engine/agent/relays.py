"""Relays of a machine: they connect its containers with the master and with endpoints that these cannot dial.

A container in Docker sees no other sockets of its host, and one on another host than the master or the endpoint neither
holds the key of its machine, with which it could impersonate the machine, nor needs a network. It dials a Unix socket,
as on the master's host, and the agent forwards the bytes, over TLS to another host. To reach an endpoint, it first
writes a line with the addresses of the endpoint, as JSON.
"""

import asyncio
import contextlib
import logging
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable
from pathlib import Path

import msgspec

from engine.protocols.address import EndpointAddress, UnixAddress, is_endpoint_socket, parse_address
from engine.protocols.sockets import Streams, dial, listen
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, MalformedMessage, NotPermitted, PPaaSError

logger = logging.getLogger(__name__)

CHUNK = 1 << 16
"""Largest number of bytes forwarded at once."""


class Relay(ABC):
    """Forwards bytes without decoding them; a slow reader slows the sender down.

    Parameters
    ----------
    path : Path
        Path of the Unix socket that containers dial; only the user of this process may connect to it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._server: asyncio.Server | None = None
        self._open: dict[asyncio.StreamWriter, str] = {}

    @abstractmethod
    async def _dial(self, reader: asyncio.StreamReader) -> tuple[str, Streams]:
        """Connect to the address to which the connection of a container is forwarded; return both.

        Raises
        ------
        PPaaSError, TimeoutError, ValueError
            The connection is closed.
        """

    async def start(self) -> None:
        """Start to listen on the socket."""
        self._server = await listen(UnixAddress(self.path), self._connected)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._open[writer] = ""
        try:
            address, (far_reader, far_writer) = await self._dial(reader)
        except (PPaaSError, TimeoutError, ValueError) as error:
            logger.warning("a container could not connect to its endpoint: %s", str(error) or "it named none in time")
            del self._open[writer]
            writer.close()
            return
        self._open |= dict.fromkeys((writer, far_writer), address)
        try:
            await _carry_both_ways((reader, writer), (far_reader, far_writer))
        finally:
            for end in (writer, far_writer):
                del self._open[end]

    async def close(self) -> None:
        """Stop listening, and close all connections."""
        if self._server is not None:
            self._server.close()
        for writer in tuple(self._open):
            writer.transport.abort()
        self.path.unlink(missing_ok=True)


async def _carry_both_ways(near: Streams, far: Streams) -> None:
    """Forward bytes between two connections until one of them ends; then close both."""
    ways = [asyncio.create_task(_carry(near[0], far[1])), asyncio.create_task(_carry(far[0], near[1]))]
    try:
        await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for end in (near[1], far[1]):
            end.close()  # what was written is still sent
        for way in ways:
            way.cancel()
        await asyncio.gather(*ways, return_exceptions=True)


async def _carry(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):  # one end disconnected: the caller closes the other
        while data := await reader.read(CHUNK):
            writer.write(data)
            await writer.drain()


LINE_TIMEOUT = 5.0
"""Time within which a connected container must write the addresses [s]."""

DialFar = Callable[[EndpointAddress], Awaitable[Streams]]
"""Connects to an endpoint of another host; raises ``Unavailable`` if it does not answer."""


class EndpointRelay(Relay):
    """Forwards the links of containers to endpoints.

    Parameters
    ----------
    path : Path
        Path of the Unix socket that containers dial.
    machine : str
        Name of the machine.
    sockets : Path
        Folder of the sockets of its endpoints.
    dial_far : callable
        Connects to an endpoint of another host.
    """

    def __init__(self, path: Path, machine: str, sockets: Path, dial_far: DialFar) -> None:
        super().__init__(path)
        self._machine = machine
        self._sockets = sockets
        self._dial_far = dial_far

    async def _dial(self, reader: asyncio.StreamReader) -> tuple[str, Streams]:
        """Connect to the endpoint that a container names.

        Raises
        ------
        InvalidInput
            The endpoint has no address for other hosts.
        MalformedMessage
            The line is not an address.
        NotPermitted
            The address does not belong to an endpoint.
        """
        async with asyncio.timeout(LINE_TIMEOUT):
            line = await reader.readline()
        try:
            named = from_json(line, EndpointAddress)
        except msgspec.DecodeError as error:
            raise MalformedMessage(f"a container must name its endpoint first: {error}") from error
        if named.machine == self._machine:
            return named.near, await self._dial_near(named.near)
        if not named.far:
            raise InvalidInput("the endpoint has no address for other hosts: start the cloud with --listen-machines")
        return named.far, await self._dial_far(named)

    async def _dial_near(self, text: str) -> Streams:
        address = parse_address(text)
        if not isinstance(address, UnixAddress) or not is_endpoint_socket(address.path, self._sockets):
            raise NotPermitted(f"{text[:128]!r} is not the address of an endpoint of this host")
        return await dial(address)


class RobotLinkRelay(Relay):
    """Forwards the robot links of containers.

    Parameters
    ----------
    path : Path
        Path of the Unix socket that containers dial.
    dial : callable
        Connects to an address; raises ``Unavailable`` if nobody answers.
    where : callable
        Returns the current address of the master.
    """

    def __init__(self, path: Path, dial: Callable[[str], Awaitable[Streams]], where: Callable[[], str]) -> None:
        super().__init__(path)
        self._dial_master = dial
        self._where = where

    async def _dial(self, _reader: asyncio.StreamReader) -> tuple[str, Streams]:
        address = self._where()
        return address, await self._dial_master(address)

    def leave_others(self) -> None:
        """Abort the connections to other addresses than the current one: a stopped master never closes them."""
        for writer, address in tuple(self._open.items()):
            if address and address != self._where():  # without one, it is being dialled
                writer.transport.abort()
