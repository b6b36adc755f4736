"""HTTP protocol of uvicorn with limits of heads, times and connections, which passes bodies on without copies.

Every state in which the client must act has a time limit: a head must arrive, the rest of a body that was answered
already, the next request, and the reading of an answer. Bodies have separate limits (`endpoints.http.body_limit`).
"""

import asyncio
import http
import logging
import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, ClassVar, cast

import httptools
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from endpoints.http.connection_table import ConnectionTable
from endpoints.http.problems import status_problem
from endpoints.http.websocket_protocol import DirectWebSocket

logger = logging.getLogger(__name__)


# Limits and rules of the head of a request: its request line and its header lines.

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


REST_SECONDS = 30.0
"""Time limit for the rest of a body that was answered already [s]; it is dropped, so the client can read the answer."""

REST_OF_HEAD = 64 << 10
REST_OF_BODY = 16 << 20
"""Largest part of a refused head, and of a body whose answer closes the connection, that is dropped [bytes]."""

UNREAD_SECONDS = 120.0
"""Time limit for a client to read a block of an answer [s]."""

MAX_PIPELINED = 16
"""Largest number of requests that wait for the answer to an earlier one of their connection."""

_HEAD, _NEXT, _REST, _CLOSING = "head", "next", "rest", "closing"
"""States in which the client must act: send a head, send another request, send the rest of a body, read the answer."""


class DirectHttp(HttpToolsProtocol):
    """Connection of a client.

    A block of a body is passed to the application without a copy if the previous blocks were consumed. Large bodies are
    always read like this, because reading pauses until the application has consumed them. uvicorn copies each block
    twice, into a growing buffer and out of it.

    Attributes
    ----------
    table : ConnectionTable
        Table of the connections of the server.
    """

    table: ClassVar[ConnectionTable] = ConnectionTable()

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._in_head = True
        self._begun = False  # whether a part of a head has arrived
        self._declined = False  # whether the request offers a protocol other than WebSocket
        self._lines = 0
        self._progress = 0  # number of complete heads, blocks of bodies and complete requests
        self._stalled = 0  # number of bytes since the last of these
        self._deaf = False  # whether further data is dropped
        self._lingering = False  # whether the last answer was sent
        self._rest = 0  # number of bytes that may still be dropped then
        self._state: str | None = None
        self._timer: asyncio.TimerHandle | None = None
        self._unread: asyncio.TimerHandle | None = None
        self._answers: _AnswerTransport

    # -- connection ----------------------------------------------------------------------------------------------------

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn has it
        """Handle a new connection; refuse it if there are too many."""
        super().connection_made(transport)
        self._answers = _AnswerTransport(transport, self._close)
        if self.table.admit(self, self.client[0] if self.client is not None else ""):
            self._watch()
        else:
            self._deaf = True
            transport.write(_TOO_MANY)
            self._end()

    def connection_lost(self, exc: Exception | None) -> None:
        """Handle the end of the connection."""
        self.table.leave(self)
        self._stop_timers()
        super().connection_lost(exc)

    def make_room(self) -> None:
        """Close the connection, which waits for a request, because there are too many."""
        self._end()

    def pause_writing(self) -> None:
        """Handle that the client reads more slowly than the application writes."""
        super().pause_writing()
        self._unread = self.loop.call_later(UNREAD_SECONDS, self.transport.abort)

    def resume_writing(self) -> None:
        """Handle that the client has read."""
        super().resume_writing()
        if self._unread is not None:
            self._unread.cancel()
            self._unread = None

    # -- requests ------------------------------------------------------------------------------------------------------

    def data_received(self, data: bytes) -> None:
        """Handle received data."""
        if self._dropped(len(data)):
            return
        at = 0
        while at < len(data) and not self._deaf:
            end = at + MAX_HEAD - self._stalled if self._in_head else len(data)
            at += self._feed(data[at:end])
        if not self._dropped(len(data) - at) and self._state != _CLOSING:
            self._watch()

    def _feed(self, data: bytes) -> int:
        """Parse a block; return the number of bytes that were consumed."""
        before, consumed = self._progress, len(data)
        try:
            consumed = self._parse(data)
        except httptools.HttpParserError as error:
            known = error.__context__
            self._refuse(known if isinstance(known, BadHead) else BadHead(400, f"the request is not HTTP: {error}"))
        self._stalled = 0 if self._progress != before else self._stalled + consumed
        if self._stalled >= MAX_HEAD and not self._deaf:
            self._refuse(too_large())
        return consumed

    def _parse(self, data: bytes) -> int:
        try:
            self.parser.feed_data(data)
        except httptools.HttpParserUpgrade as upgrade:
            if not self._declined:
                self.handle_websocket_upgrade()
                return len(data)
            # The parser skips the body of a request that offers another protocol, which a server may ignore
            # (RFC 9110, 7.8). Java's client offers HTTP/2 with each request. So the head is parsed without the offer.
            self._declined = False
            self.parser = new_parser(self)
            self.parser.feed_data(head_without_offer(self.scope["method"], self.url, self.headers))
            return int(upgrade.args[0])
        return len(data)

    def on_message_begin(self) -> None:
        """Handle the first byte of a request."""
        super().on_message_begin()
        self._begun = True
        self._lines = 0

    def on_header(self, name: bytes, value: bytes) -> None:
        """Handle a header line, or a trailer after the body, which is dropped (RFC 9110, 6.5.1)."""
        self._lines += 1
        if self._lines > MAX_LINES:
            raise too_large()
        if self._in_head:
            super().on_header(name, value)

    def on_headers_complete(self) -> None:
        """Handle the end of a head."""
        offer = self.parser.should_upgrade()
        websocket = offer and self._should_upgrade()
        check_head(self.parser.get_http_version(), self.headers, websocket=websocket)
        if offer and not websocket:
            self._decline()
            return
        if len(self.pipeline) >= MAX_PIPELINED:
            raise BadHead(400, f"at most {MAX_PIPELINED} requests of a connection may wait: send fewer at once")
        self._in_head = self._begun = False
        self._progress += 1
        super().on_headers_complete()
        if not websocket:
            self.cycle.transport = cast(asyncio.Transport, self._answers)

    def _decline(self) -> None:
        method = self.parser.get_method()
        if method == b"CONNECT":
            raise BadHead(501, "this server is not a proxy: CONNECT is not supported")
        self.scope["method"] = method.decode("ascii")
        self._declined = True

    def on_body(self, body: bytes) -> None:
        """Handle a received block of a body."""
        self._progress += 1
        if self.cycle is not None and not self.cycle.body:
            self.cycle.body = b""  # type: ignore[assignment]  # b"" + block, and bytes(block), are the block itself
        super().on_body(body)

    def on_message_complete(self) -> None:
        """Handle the end of a request."""
        if self._declined:
            return
        self._in_head = True
        self._progress += 1
        super().on_message_complete()

    def handle_websocket_upgrade(self) -> None:
        """Pass the connection to the WebSocket protocol."""
        self._deaf = True
        self._state = None
        self._stop_timers()
        self.table.serve(self)
        super().handle_websocket_upgrade()
        protocol = self.transport.get_protocol()
        if isinstance(protocol, DirectWebSocket):
            protocol.on_lost = partial(self.table.leave, self)
        else:
            self.table.leave(self)

    # -- answers -------------------------------------------------------------------------------------------------------

    def on_response_complete(self) -> None:
        """Handle that an answer was written; start the next request."""
        self.server_state.total_requests += 1
        if self.transport.is_closing() or self._lingering:
            return
        self.flow.resume_reading()
        if self.pipeline:
            self._start_asgi_task(*self.pipeline.pop())
        self._watch()

    def _refuse(self, fault: BadHead) -> None:
        """Answer an invalid request and close the connection, after the answers to earlier requests."""
        logger.debug("request of %s refused: %d %s", self.client, fault.status, fault)
        self._deaf = True
        cycle = self.cycle
        if cycle is not None and not cycle.response_complete:
            if self._in_head:
                cycle.keep_alive = False
                return
            cycle.disconnected = True
            cycle.message_event.set()
            if cycle.response_started or self.pipeline:
                self._end()
                return
        self.transport.write(_answer(fault.status, str(fault)))
        self._close()

    def _close(self) -> None:
        """Close the connection after its last answer.

        If the client still sends, what it sends is dropped for a time. A connection that is closed before all was read
        is reset, and the client may lose the answer (RFC 9112, 9.6).
        """
        if not self._deaf and self._in_head:
            self._end()
            return
        self._rest = REST_OF_HEAD if self._in_head else REST_OF_BODY
        self._deaf = self._lingering = True
        if self.transport.can_write_eof() and not self.transport.is_closing():
            self.transport.write_eof()
        self.flow.resume_reading()
        self._watch()

    def _dropped(self, count: int) -> bool:
        """Return whether data follows the last answer and is dropped; reset the connection if there is too much."""
        if self._lingering:
            self._rest -= count
            if self._rest < 0:
                self.transport.abort()
        return self._lingering

    def _end(self) -> None:
        self.transport.close()
        self._set_state(_CLOSING, UNREAD_SECONDS)

    # -- time limits ---------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        """Start or stop the time limit of the state of the connection."""
        if self._lingering:
            self._set_state(_REST, REST_SECONDS)
        elif self._deaf:
            self._set_state(None, 0.0)
        elif self.cycle is None or self._begun or (self._in_head and self._stalled):
            self._set_state(_HEAD, HEAD_SECONDS)
        elif not self.cycle.response_complete:
            self._set_state(None, 0.0)
        elif self._in_head:
            self._set_state(_NEXT, self.timeout_keep_alive)
        else:
            self._set_state(_REST, REST_SECONDS)

    def _set_state(self, state: str | None, seconds: float) -> None:
        if state == self._state:
            return
        self._state = state
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if state is None:
            self.table.serve(self)
        else:
            self.table.wait(self)
            self._timer = self.loop.call_later(seconds, self._expired)

    def _expired(self) -> None:
        self._timer = None
        if self._state == _HEAD and self._begun:
            self._refuse(BadHead(408, f"the head of the request did not arrive within {HEAD_SECONDS:g} s"))
        elif self._state in (_HEAD, _NEXT):
            self._end()
        else:
            self.transport.abort()

    def _stop_timers(self) -> None:
        for timer in (self._timer, self._unread):
            if timer is not None:
                timer.cancel()
        self._timer = self._unread = None


class _AnswerTransport:
    """Part of a transport that uvicorn uses for answers, with another way to close it."""

    def __init__(self, transport: asyncio.Transport, close: Callable[[], None]) -> None:
        self.write = transport.write
        self.is_closing = transport.is_closing
        self.close = close


def new_parser(protocol: HttpToolsProtocol) -> httptools.HttpRequestParser:
    """Return a parser like uvicorn's, which answers a request although others follow it."""
    parser = httptools.HttpRequestParser(protocol)
    parser.set_dangerous_leniencies(lenient_data_after_close=True)
    return parser


def http_protocol(connections: ConnectionTable) -> type[DirectHttp]:
    """Return the protocol of a server with this table of connections."""

    class TableHttp(DirectHttp):
        """Connection of this server."""

        table = connections

    return TableHttp


def _answer(status: int, text: str) -> bytes:
    response = status_problem(status, text, {"Connection": "close"})
    phrase = http.HTTPStatus(status).phrase.encode()
    lines = [b"HTTP/1.1 %d %s" % (status, phrase), *(b"%s: %s" % header for header in response.raw_headers)]
    return b"\r\n".join(lines) + b"\r\n\r\n" + bytes(response.body)


_TOO_MANY = _answer(503, "this cloud has too many connections: try again later")
