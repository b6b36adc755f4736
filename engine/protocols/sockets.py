"""To listen and to dial, whatever the address; what is framed over it is the same."""

import asyncio
import ssl
from collections.abc import Awaitable, Callable

from engine.protocols.address import Address, UnixAddress
from engine.protocols.tls_identity import CLOUD_NAME
from ppaas.errors import InvalidInput, Unavailable

ConnectionHandler = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]
Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]

HANDSHAKE_TIMEOUT = 5.0
"""Seconds that whoever dials over TLS has to show its certificate."""


async def listen(
    address: Address, connected: ConnectionHandler, context: ssl.SSLContext | None = None
) -> asyncio.Server:
    """Listen.

    Parameters
    ----------
    address : Address
        Of a Unix socket, which only this user may dial, or of a port.
    connected : callable
        Serves each connection.
    context : SSLContext, optional
        For a port, which is not opened without.

    Raises
    ------
    Unavailable
        The address is not ours, or taken.
    """
    try:
        if isinstance(address, UnixAddress):
            server = await asyncio.start_unix_server(connected, address.path)
            address.path.chmod(0o600)
            return server
        return await asyncio.start_server(
            connected, address.host, address.port, ssl=_needed(context), ssl_handshake_timeout=HANDSHAKE_TIMEOUT
        )
    except OSError as error:
        raise Unavailable(f"cannot listen at {address}: {error.strerror or error}") from error


async def dial(address: Address, context: ssl.SSLContext | None = None) -> Streams:
    """Dial.

    Raises
    ------
    Unavailable
        Nobody answers there, or whoever does is not our cloud.
    """
    try:
        if isinstance(address, UnixAddress):
            return await asyncio.open_unix_connection(address.path)
        return await asyncio.open_connection(
            address.host,
            address.port,
            ssl=_needed(context),
            server_hostname=CLOUD_NAME,  # it shows who it is, at whatever host it is reached
            ssl_handshake_timeout=HANDSHAKE_TIMEOUT,
        )
    except OSError as error:  # what TLS raises is one as well
        raise Unavailable(f"no answer at {address}: {error.strerror or error}") from error


def _needed(context: ssl.SSLContext | None) -> ssl.SSLContext:
    if context is None:
        raise InvalidInput("a link between machines needs certificates: have this machine join by a ticket first")
    return context
