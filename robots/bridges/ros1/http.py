"""XML-RPC over HTTP without blocking: calls of the master and of other nodes, and a server for their calls."""

import asyncio
from collections.abc import Callable, Mapping
from typing import Any
from urllib.parse import urlsplit

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, MessageTooLarge, PPaaSError, Unavailable
from ppaas.wire.ros.ros1_master import (
    ERROR,
    MAX_CALL,
    MAX_RESPONSE,
    pack_call,
    pack_fault,
    pack_response,
    unpack_call,
    unpack_response,
)

try:
    import h11
except ImportError as error:
    raise InvalidInput(f"robots with ROS 1 need the extra ros1: {install_hint('ros1')}") from error

CALL_TIMEOUT = 3.0
"""Time limit of a call [s]."""

IDLE_TIMEOUT = 15.0
"""Time after which the server closes a connection without a call [s]."""

MAX_CONNECTIONS = 64
"""Largest number of connections to the server at once."""

CHUNK = 1 << 16

Method = Callable[..., tuple[int, str, Any]]
"""Called with the arguments of a call; returns status, text and value of the response."""


def address_of(uri: str) -> tuple[str, int]:
    """Return host and port of the URI of a master or a node.

    Raises
    ------
    InvalidInput
        It is not such a URI.
    """
    try:
        parts = urlsplit(uri)
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if not host or not port or parts.scheme != "http":
        raise InvalidInput(f"not the URI of a master or a node: {uri[:200]!r}; write http://HOST:PORT")
    return host, port


async def call(uri: str, method: str, *arguments: Any) -> Any:
    """Call a method of a master or a node; return the value of the response.

    Raises
    ------
    Unavailable
        There was no response in time, or the call failed.
    InvalidInput
        The URI or the response is invalid.
    """
    host, port = address_of(uri)
    try:
        async with asyncio.timeout(CALL_TIMEOUT):
            reader, writer = await asyncio.open_connection(host, port)
            try:
                return unpack_response(await _exchange(reader, writer, host, pack_call(method, *arguments)))
            finally:
                writer.close()
    except (OSError, TimeoutError, UnicodeError, h11.ProtocolError) as error:
        raise Unavailable(f"{uri} does not answer {method}: {error or 'no response in time'}") from error


async def _exchange(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, host: str, body: bytes) -> bytes:
    connection = h11.Connection(h11.CLIENT)
    headers = [
        ("Host", host),
        ("Content-Type", "text/xml"),
        ("Content-Length", str(len(body))),
        ("User-Agent", "ppaas"),
    ]
    _send(connection, writer, h11.Request(method="POST", target="/", headers=headers), body)
    event = await _next_event(connection, reader)
    while isinstance(event, h11.InformationalResponse):
        event = await _next_event(connection, reader)
    if not isinstance(event, h11.Response) or event.status_code != 200:
        raise h11.RemoteProtocolError("no response of HTTP with status 200")
    return await _body(connection, reader, MAX_RESPONSE)


def _send(
    connection: h11.Connection, writer: asyncio.StreamWriter, head: h11.Request | h11.Response, body: bytes
) -> None:
    for event in (head, h11.Data(data=body), h11.EndOfMessage()):
        writer.write(connection.send(event) or b"")


async def _next_event(connection: h11.Connection, reader: asyncio.StreamReader) -> object:
    while True:
        event = connection.next_event()
        if event is not h11.NEED_DATA:
            return event
        connection.receive_data(await reader.read(CHUNK))


async def _body(connection: h11.Connection, reader: asyncio.StreamReader, limit: int) -> bytes:
    body = bytearray()
    while isinstance(event := await _next_event(connection, reader), h11.Data):
        body += event.data
        if len(body) > limit:
            raise MessageTooLarge(f"more than {limit} bytes of XML-RPC")
    return bytes(body)


class XmlRpcServer:
    """Server of a node.

    Parameters
    ----------
    methods : mapping
        Methods by name.
    """

    def __init__(self, methods: Mapping[str, Method]) -> None:
        self._methods = methods
        self._server: asyncio.Server | None = None
        self._serving: set[asyncio.Task[None]] = set()

    async def listen(self, host: str) -> int:
        """Listen on a free port of an address; return the port."""
        self._server = await asyncio.start_server(self._connected, host, 0)
        port: int = self._server.sockets[0].getsockname()[1]
        return port

    async def close(self) -> None:
        """Close the server and its connections."""
        if self._server is not None:
            self._server.close()
        for task in self._serving:
            task.cancel()
        await asyncio.gather(*self._serving, return_exceptions=True)

    def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if len(self._serving) >= MAX_CONNECTIONS:
            writer.close()
            return
        task = asyncio.create_task(self._serve(reader, writer))
        self._serving.add(task)
        task.add_done_callback(self._serving.discard)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        connection = h11.Connection(h11.SERVER)
        try:
            while await self._serve_one(connection, reader, writer):
                connection.start_next_cycle()
        except (OSError, TimeoutError, h11.ProtocolError, MessageTooLarge):
            return  # the caller has gone, is silent, or speaks another protocol
        finally:
            writer.close()

    async def _serve_one(
        self, connection: h11.Connection, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> bool:
        """Answer one call; return whether another may follow on this connection."""
        async with asyncio.timeout(IDLE_TIMEOUT):
            if not isinstance(await _next_event(connection, reader), h11.Request):
                return False
            self._respond(connection, writer, await _body(connection, reader, MAX_CALL))
            await writer.drain()
        return connection.states == {h11.CLIENT: h11.DONE, h11.SERVER: h11.DONE}

    def _respond(self, connection: h11.Connection, writer: asyncio.StreamWriter, body: bytes) -> None:
        try:
            method, arguments = unpack_call(body)
            text = pack_response(*self._call(method, arguments))
        except PPaaSError as error:
            text = pack_fault(str(error))
        headers = [("Content-Type", "text/xml"), ("Content-Length", str(len(text)))]
        _send(connection, writer, h11.Response(status_code=200, headers=headers), text)

    def _call(self, name: str, arguments: tuple[Any, ...]) -> tuple[int, str, Any]:
        method = self._methods.get(name)
        if method is None:
            return ERROR, f"unknown method {name[:64]!r}; known: {', '.join(self._methods)}", 0
        try:
            return method(*arguments)
        except (TypeError, ValueError, PPaaSError) as error:
            return ERROR, f"wrong arguments of {name}: {error}", 0
