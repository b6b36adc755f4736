"""Frames, probes and ends of WebSockets over real sockets."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from starlette.responses import PlainTextResponse
from starlette.websockets import WebSocket
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus
from websockets.frames import CloseCode, Frame, Opcode

from endpoints.http import frame_pacing, websocket_protocol
from endpoints.http.problems import RefusalLog
from endpoints.http.websocket_protocol import DirectWebSocket, connection_of
from ppaas.wire.binary.binary_frame import BinaryFrame
from tests.support.endpoints.serving import serve
from tests.support.waiting import patience


@pytest.fixture(autouse=True)
def _unused_log(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websocket_protocol, "refusals", RefusalLog(websocket_protocol.logger))


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


class Taken:
    """Messages that were taken past ASGI: their content, and whether they are binary."""

    def __init__(self) -> None:
        self.queue: asyncio.Queue[tuple[bytes, bool]] = asyncio.Queue()

    def __call__(self, content: bytes, *, binary: bool) -> None:
        self.queue.put_nowait((content, binary))

    async def get(self) -> tuple[bytes, bool]:
        async with patience(10):
            return await self.queue.get()


def ignore(content: bytes, *, binary: bool) -> None:
    """Drop a message."""


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


async def test_text_and_binary_messages_are_delivered_in_order_as_bytes() -> None:
    async with connected(Server()) as (client, connection):
        taken = Taken()
        connection.hand_to(taken)
        await client.send("one")
        await client.send(["t", "w", "ö"])
        await client.send(b"drei")
        await client.send([b"f\xc3", b"", b"\xbcnf"])
        await client.send(b"\xff")
        assert [await taken.get() for _ in range(5)] == [
            (b"one", False), ("twö".encode(), False),
            (b"drei", True), ("fünf".encode(), True), (b"\xff", True),
        ]  # fmt: skip


async def test_frames_return_to_asgi_once_the_receiver_is_removed() -> None:
    server = Server()
    async with connected(server) as (client, connection):
        taken = Taken()
        connection.hand_to(taken)
        connection.hand_to(None)
        await client.send("for ASGI")
        assert await server.heard.get() == "for ASGI"
        assert taken.queue.empty()


async def test_invalid_utf8_closes_the_connection_and_is_not_delivered() -> None:
    async with connected(Server()) as (client, connection):
        taken = Taken()
        connection.hand_to(taken)
        await client.send(b"\xff\xfe", text=True)
        await client.wait_closed()
        assert client.close_code == CloseCode.INVALID_DATA
        assert taken.queue.empty()


async def test_readiness_follows_flow_control_and_resumption_is_reported() -> None:
    async with connected(Server()) as (client, connection):
        again = asyncio.Event()
        connection.hand_to(ignore, again.set)
        connection.send_frame(b"sent past ASGI")
        assert await client.recv() == "sent past ASGI"
        connection.send_frame(BinaryFrame(b"\xff"))
        assert await client.recv() == b"\xff"
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
        async with patience(10):
            assert all([await round_trips.get() >= 0.0 for _ in range(2)])  # uvloop counts milliseconds
            assert await connection.probe(10.0)


# -- what one client must not do to others -----------------------------------------------------------------------------


async def _send(client: ClientConnection, *frames: Frame) -> None:
    client.transport.write(b"".join(frame.serialize(mask=True) for frame in frames))
    await asyncio.sleep(0)


async def test_of_many_pings_in_one_turn_the_last_is_answered() -> None:
    async with connected(Server()) as (client, _):
        answered = [await client.ping() for _ in range(3)]
        await _send(client, *(Frame(Opcode.PING, b"%d" % number) for number in range(2000)))
        last = await client.ping()
        async with patience(10):
            await asyncio.gather(last, *answered)


async def test_pongs_for_a_peer_that_does_not_read_are_dropped() -> None:
    async with connected(Server()) as (client, connection):
        connection.pause_writing()
        await _send(client, *(Frame(Opcode.PING, b"x" * 125) for _ in range(100)))
        taken = Taken()
        connection.hand_to(taken)
        await client.send("after the pings")
        assert await taken.get() == (b"after the pings", False)
        assert connection.transport.get_write_buffer_size() == 0


async def test_a_message_in_a_million_fragments_takes_the_memory_of_its_bytes() -> None:
    async with connected(Server()) as (client, connection):
        taken = Taken()
        connection.hand_to(taken)
        empty = Frame(Opcode.CONT, b"", fin=False)
        await _send(client, Frame(Opcode.BINARY, b"a", fin=False), *[empty] * 1000, Frame(Opcode.CONT, b"z"))
        assert await taken.get() == (b"az", True)
        assert connection.frames == []


@pytest.mark.parametrize("begun", [b"\x01\x81....{", b"\x81\xfe\x01\x00...."], ids=["fragment", "part of a frame"])
async def test_a_message_that_is_not_completed_in_time_closes_the_connection(
    begun: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(websocket_protocol, "MESSAGE_TIMEOUT", 0.1)
    async with connected(Server()) as (client, _):
        client.transport.write(begun)
        async with patience(10):
            await client.wait_closed()
        assert client.close_code == CloseCode.POLICY_VIOLATION
        assert "not completed" in (client.close_reason or "")


async def test_a_flood_is_closed_with_a_reason_that_the_peer_hears(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(frame_pacing, "OVERLOAD", 0.05)
    monkeypatch.setattr(frame_pacing, "FRAMES", 1000.0)
    monkeypatch.setattr(frame_pacing, "BURST", 0.01)
    server = Server()
    async with connected(server) as (client, connection):
        connection.name = "robot ann/tb1"
        connection.hand_to(ignore)
        await _send(client, *[Frame(Opcode.TEXT, b"{}")] * 100_000)
        async with patience(10):
            await client.wait_closed()
            await server.ended.wait()
        assert client.close_code == CloseCode.POLICY_VIOLATION
        assert "too many frames" in (client.close_reason or "")
    [record] = caplog.records
    assert record.levelname == "WARNING"
    assert record.getMessage().startswith("127.0.0.1: robot ann/tb1: closed with code 1008: too many frames")


# -- what refusals look like in the log --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sent", "code"),
    [
        (Frame(Opcode.TEXT, b"\xff\xfe").serialize(mask=True), CloseCode.INVALID_DATA),
        (Frame(Opcode.TEXT, b"{}").serialize(mask=False), CloseCode.PROTOCOL_ERROR),
        (b"\xa1\x80....", CloseCode.PROTOCOL_ERROR),
        (Frame(Opcode.CONT, b"{}").serialize(mask=True), CloseCode.PROTOCOL_ERROR),
        (b"\x83\x80....", CloseCode.PROTOCOL_ERROR),
        (b"\x81\xff" + b"\x7f" * 8 + b"....", CloseCode.MESSAGE_TOO_BIG),
    ],
    ids=["no UTF-8", "no mask", "reserved bit", "no begin", "unknown opcode", "too large"],
)
async def test_an_invalid_frame_is_one_warning_with_name_and_address(
    sent: bytes, code: CloseCode, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    server = Server()
    async with connected(server) as (client, connection):
        connection.name = "robot ann/tb1"
        connection.hand_to(ignore)
        client.transport.write(sent)
        async with patience(10):
            await client.wait_closed()
            await server.ended.wait()
        assert client.close_code == code
    records = [record for record in caplog.records if record.levelno >= logging.WARNING]
    assert [(record.levelname, record.exc_info) for record in records] == [("WARNING", None)]
    assert records[0].getMessage().startswith(f"127.0.0.1: robot ann/tb1: closed with code {int(code)}: ")


async def test_a_refused_handshake_is_no_error_of_the_server(caplog: pytest.LogCaptureFixture) -> None:
    async def refuse(scope: Any, receive: Any, send: Any) -> None:
        await WebSocket(scope, receive, send).send_denial_response(PlainTextResponse("no", 401))

    async with serve(refuse) as port:
        with pytest.raises(InvalidStatus):
            await connect(f"ws://127.0.0.1:{port}/")
    assert [record for record in caplog.records if record.levelno >= logging.WARNING] == []
