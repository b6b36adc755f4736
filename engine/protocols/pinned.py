"""Dials servers that are known by the fingerprint of their certificate, and not by a name in it."""

import hashlib
import ssl

from engine.protocols.address import TlsAddress
from engine.protocols.sockets import Streams, dial
from ppaas.errors import NotPermitted


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
