"""Endpoint relay: connects a machine's containers with endpoints that they cannot dial themselves.

A container in Docker sees no other sockets of its host, and one on another host than the endpoint neither holds the key
of its machine nor needs a network. It dials the relay, and writes a line with the addresses of the endpoint, as JSON.
"""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

import msgspec

from engine.agent.relays.relay import Relay
from engine.protocols.address import UnixAddress, parse_address
from engine.protocols.endpoint_sockets import EndpointAddress, is_endpoint_socket
from engine.protocols.sockets import Streams, dial
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, MalformedMessage, NotPermitted

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
