"""Limits and rules of the head of an HTTP request: its request line and its header lines."""

import re
from collections.abc import Sequence

MAX_HEAD = 32 << 10
"""Largest head of a request, and largest part of a body without content: chunk extensions and trailers [bytes]."""

MAX_LINES = 128
"""Largest number of header lines of a request, trailers included."""

HEAD_SECONDS = 20.0
"""Time limit from a new connection, or from the first byte of a later request, to the end of the head [s]."""

_HOST = re.compile(rb"[A-Za-z0-9._~!$&'()*+,;=%:\[\]-]*")
_VERSIONS = ("1.0", "1.1")


class BadHead(Exception):
    """Head of a request that is refused.

    Parameters
    ----------
    status : int
        HTTP status of the answer.
    text : str
        Description of the fault, with advice.
    """

    def __init__(self, status: int, text: str) -> None:
        super().__init__(text)
        self.status = status


def check_head(version: str, headers: Sequence[tuple[bytes, bytes]], *, websocket: bool) -> None:
    """Check the version and the Host of a request.

    Parameters
    ----------
    version : str
        Version of HTTP, such as ``1.1``.
    headers : sequence of (bytes, bytes)
        Names in lower case, and values.
    websocket : bool
        Whether the request is the handshake of a WebSocket.

    Raises
    ------
    BadHead
        The version is not supported (RFC 9110, 15.6.6), a handshake is older than HTTP/1.1 (RFC 6455, 4.2.1) or has a
        body, or the Host is missing, repeated or invalid (RFC 9112, 3.2).
    """
    if version not in _VERSIONS:
        raise BadHead(505, f"HTTP/{version} is not supported: use HTTP/1.1")
    if websocket and version != "1.1":
        raise BadHead(400, "the handshake of a WebSocket needs HTTP/1.1: configure any proxy in between for it")
    if websocket and any(
        (name == b"content-length" and value != b"0") or name == b"transfer-encoding" for name, value in headers
    ):
        raise BadHead(400, "the handshake of a WebSocket must not have a body")
    hosts = [value for name, value in headers if name == b"host"]
    if len(hosts) > 1 or (not hosts and version == "1.1"):
        raise BadHead(400, f"a request must have one Host header, not {len(hosts)}")
    if hosts and not _HOST.fullmatch(hosts[0].strip()):
        raise BadHead(400, "the Host header must be the name or address of this server, perhaps with a port")


def head_without_offer(method: str, target: bytes, headers: Sequence[tuple[bytes, bytes]]) -> bytes:
    """Return the head of an HTTP/1.1 request without its offer of another protocol."""
    lines = [b"%s: %s" % header for header in headers if header[0] != b"upgrade"]
    return b"\r\n".join([b"%s %s HTTP/1.1" % (method.encode(), target), *lines, b"", b""])


def too_large() -> BadHead:
    """Return the refusal of a head that is too long."""
    return BadHead(431, f"the head of a request may have {MAX_HEAD} bytes and {MAX_LINES} lines: send fewer headers")
