"""Whether the other end of a WebSocket is there, asked over real sockets."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from starlette.websockets import WebSocket
from websockets.asyncio.client import ClientConnection, connect

from endpoints import websocket_protocol
from endpoints.websocket_protocol import Probe, probe_of
from tests.support.serving import serve


class Server:
    """Accepts WebSockets, and notes how each ended."""

    def __init__(self) -> None:
        self.sockets: asyncio.Queue[WebSocket] = asyncio.Queue()
        self.ended = asyncio.Event()
        self.send = ""

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        socket = WebSocket(scope, receive, send)
        await socket.accept()
        self.sockets.put_nowait(socket)
        if self.send:
            await socket.send_text(self.send)
        while (await socket.receive())["type"] != "websocket.disconnect":
            pass
        self.ended.set()


@asynccontextmanager
async def connected(server: Server, **options: Any) -> AsyncIterator[tuple[ClientConnection, Probe]]:
    async with serve(server, **options) as port, connect(f"ws://127.0.0.1:{port}/", max_size=None) as client:
        yield client, probe_of(await server.sockets.get())


async def test_a_client_that_is_there_answers_also_several_probes_at_once() -> None:
    async with connected(Server()) as (_, probe):
        assert await asyncio.gather(*(probe(10.0) for _ in range(3))) == [True] * 3


async def test_a_client_that_is_silent_does_not_and_may_do_so_later() -> None:
    async with connected(Server()) as (client, probe):
        client.transport.pause_reading()
        assert await probe(0.05) is False
        client.transport.resume_reading()
        assert await probe(10.0) is True


async def test_a_client_that_has_gone_is_not_asked() -> None:
    server = Server()
    async with connected(server) as (client, probe):
        client.transport.abort()
        await server.ended.wait()
        assert await probe(10.0) is False


async def test_a_silent_client_is_cut_off_though_much_waits_for_it() -> None:
    server = Server()
    server.send = "x" * (32 << 20)
    async with connected(server, ws_ping_interval=0.1, ws_ping_timeout=0.1) as (client, _):
        client.transport.pause_reading()
        async with asyncio.timeout(10.0 * websocket_protocol.ABORT_GRACE):
            await server.ended.wait()
        client.transport.abort()


async def test_where_the_server_cannot_ask_a_client_counts_as_there() -> None:
    async def nothing(*_: Any) -> Any: ...

    socket = WebSocket({"type": "websocket"}, nothing, nothing)
    assert await probe_of(socket)(0.0) is True
