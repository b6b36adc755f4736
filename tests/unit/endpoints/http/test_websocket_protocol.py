"""Probes of WebSocket peers over real sockets."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from starlette.websockets import WebSocket
from websockets.asyncio.client import ClientConnection, connect
from websockets.frames import CloseCode

from endpoints.http import websocket_protocol
from endpoints.http.websocket_protocol import DirectWebSocket, connection_of
from tests.support.endpoints.serving import serve


class Server:
    """Accepts WebSockets, and notes how each ended."""

    def __init__(self) -> None:
        self.sockets: asyncio.Queue[WebSocket] = asyncio.Queue()
        self.ended = asyncio.Event()
        self.send = ""
        self.heard: asyncio.Queue[str] = asyncio.Queue()

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        socket = WebSocket(scope, receive, send)
        await socket.accept()
        self.sockets.put_nowait(socket)
        if self.send:
            await socket.send_text(self.send)
        while (message := await socket.receive())["type"] != "websocket.disconnect":
            self.heard.put_nowait(message["text"])
        self.ended.set()


@asynccontextmanager
async def connected(server: Server, **options: Any) -> AsyncIterator[tuple[ClientConnection, DirectWebSocket]]:
    async with serve(server, **options) as port, connect(f"ws://127.0.0.1:{port}/", max_size=None) as client:
        yield client, connection_of(await server.sockets.get())


async def test_a_live_client_answers_concurrent_probes() -> None:
    async with connected(Server()) as (_, connection):
        assert await asyncio.gather(*(connection.probe(10.0) for _ in range(3))) == [True] * 3


async def test_a_probe_fails_while_the_client_does_not_read() -> None:
    async with connected(Server()) as (client, connection):
        client.transport.pause_reading()
        assert await connection.probe(0.05) is False
        client.transport.resume_reading()
        assert await connection.probe(10.0) is True


async def test_a_probe_of_a_disconnected_client_fails() -> None:
    server = Server()
    async with connected(server) as (client, connection):
        client.transport.abort()
        await server.ended.wait()
        assert await connection.probe(10.0) is False


async def test_an_unresponsive_client_with_pending_data_is_disconnected() -> None:
    server = Server()
    server.send = "x" * (32 << 20)
    async with connected(server, ws_ping_interval=0.1, ws_ping_timeout=0.1) as (client, _):
        client.transport.pause_reading()
        async with asyncio.timeout(10.0 * websocket_protocol.ABORT_GRACE):
            await server.ended.wait()
        client.transport.abort()


# -- frames, past ASGI -------------------------------------------------------------------------------------------------


async def test_frames_are_delivered_in_order_with_none_for_binary() -> None:
    async with connected(Server()) as (client, connection):
        taken: asyncio.Queue[str | None] = asyncio.Queue()
        connection.hand_to(taken.put_nowait)
        await client.send("one")
        await client.send(["t", "w", "ö"])
        await client.send(b"\xff")
        assert [await taken.get() for _ in range(3)] == ["one", "twö", None]


async def test_frames_return_to_asgi_once_the_receiver_is_removed() -> None:
    server = Server()
    async with connected(server) as (client, connection):
        taken: list[str | None] = []
        connection.hand_to(taken.append)
        connection.hand_to(None)
        await client.send("for ASGI")
        assert await server.heard.get() == "for ASGI"
        assert taken == []


async def test_invalid_utf8_closes_the_connection_and_is_not_delivered() -> None:
    async with connected(Server()) as (client, connection):
        taken: list[str | None] = []
        connection.hand_to(taken.append)
        await client.send(b"\xff\xfe", text=True)
        await client.wait_closed()
        assert client.close_code == CloseCode.INVALID_DATA
        assert taken == []


async def test_readiness_follows_flow_control_and_resumption_is_reported() -> None:
    async with connected(Server()) as (client, connection):
        again = asyncio.Event()
        connection.hand_to(lambda _: None, again.set)
        connection.send_frame(b"sent past ASGI")
        assert await client.recv() == "sent past ASGI"
        assert connection.ready
        connection.pause_writing()
        assert not connection.ready
        assert not again.is_set()
        connection.resume_writing()
        assert connection.ready
        assert again.is_set()


async def test_a_closed_connection_is_not_ready() -> None:
    server = Server()
    async with connected(server) as (client, connection):
        await client.close()
        await server.ended.wait()
        assert not connection.ready


async def test_the_round_trip_of_each_answered_ping_is_reported() -> None:
    round_trips: asyncio.Queue[float] = asyncio.Queue()
    async with connected(Server(), ws_ping_interval=0.02, ws_ping_timeout=10.0) as (client, connection):
        connection.on_round_trip(round_trips.put_nowait)
        await client.send("x")
        async with asyncio.timeout(10):
            assert all([await round_trips.get() > 0.0 for _ in range(2)])
            assert await connection.probe(10.0)
