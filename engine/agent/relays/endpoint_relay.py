"""Endpoint relay: connects a machine's containers with endpoints that they cannot dial themselves.

A container in Docker sees no other sockets of its host, and one on another host than the endpoint neither holds the key
of its machine nor needs a network. It dials the relay, and writes a line with the addresses of the endpoint: that for
the endpoint's own host, and that for other hosts.
"""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

from engine.agent.relays.relay import Relay
from engine.protocols.address import UnixAddress, parse_address
from engine.protocols.endpoint_sockets import is_endpoint_socket
from engine.protocols.sockets import Streams
from ppaas.errors import InvalidInput, NotPermitted

LINE_TIMEOUT = 5.0
"""Time within which a connected container must write the addresses [s]."""


class EndpointRelay(Relay):
    """Forwards the links of containers to endpoints.

    Parameters
    ----------
    path, dial
        As of ``Relay``.
    is_far : bool
        Whether the endpoints are on other hosts.
    """

    def __init__(self, path: Path, dial: Callable[[str], Awaitable[Streams]], *, is_far: bool) -> None:
        super().__init__(path, dial)
        self._is_far = is_far

    async def _address(self, reader: asyncio.StreamReader) -> str:
        """Return the address that a container names.

        Raises
        ------
        InvalidInput
            The endpoint has no address for other hosts.
        NotPermitted
            The address is not that of an endpoint.
        """
        async with asyncio.timeout(LINE_TIMEOUT):
            line = await reader.readline()
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
