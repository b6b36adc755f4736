"""Listens and dials, at Unix sockets and over TLS.

Some servers are known by the fingerprint of their certificate, and not by a name in it.
"""

import asyncio
import hashlib
import ssl
from collections.abc import Awaitable, Callable

from engine.protocols.address import Address, TlsAddress, UnixAddress
from engine.protocols.tls_identity import CLOUD_NAME
from ppaas.errors import InvalidInput, NotPermitted, Unavailable

ConnectionHandler = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]

Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]

HANDSHAKE_TIMEOUT = 5.0
"""Time limit of a TLS handshake [s]."""


async def listen(
    address: Address, connected: ConnectionHandler, context: ssl.SSLContext | None = None
) -> asyncio.Server:
    """Listen at an address.

    Parameters
    ----------
    address : Address
        Address of a Unix socket, which only this user may dial, or of a port.
    connected : callable
        Called for each connection.
    context : SSLContext, optional
        TLS settings; required for a port.

    Raises
    ------
    Unavailable
        The address is in use, or does not belong to this host.
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
    """Connect to an address.

    Raises
    ------
    Unavailable
        There is no answer, or the server is not our cloud.
    """
    try:
        if isinstance(address, UnixAddress):
            return await asyncio.open_unix_connection(address.path)
        return await asyncio.open_connection(
            address.host,
            address.port,
            ssl=_needed(context),
            server_hostname=CLOUD_NAME,  # the name in its certificate, at any host name or address
            ssl_handshake_timeout=HANDSHAKE_TIMEOUT,
        )
    except OSError as error:  # errors of TLS are OSErrors as well
        raise Unavailable(f"no answer at {address}: {error.strerror or error}") from error


def _needed(context: ssl.SSLContext | None) -> ssl.SSLContext:
    if context is None:
        raise InvalidInput("a link between machines needs a certificate: join the cloud with a ticket first")
    return context


def fingerprint(certificate: bytes) -> str:
    """Return the SHA-256 of a certificate in DER, in hexadecimal."""
    return hashlib.sha256(certificate).hexdigest()


async def dial_pinned(address: TlsAddress, context: ssl.SSLContext, expected: str) -> Streams:
    """Connect to the server with a certificate.

    Parameters
    ----------
    address : TlsAddress
        Its address.
    context : SSLContext
        TLS settings that verify no certificate.
    expected : str
        Fingerprint of the certificate.

    Raises
    ------
    NotPermitted
        The server has another certificate; nothing was sent to it.
    Unavailable
        It does not answer.
    """
    reader, writer = await dial(address, context)
    shown = writer.get_extra_info("ssl_object").getpeercert(binary_form=True)
    if fingerprint(shown) != expected:
        writer.transport.abort()
        raise NotPermitted(
            f"the server at {address} is another one than expected: its certificate is not the known one"
        )
    return reader, writer
