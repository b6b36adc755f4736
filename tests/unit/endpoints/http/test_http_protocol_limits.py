"""Incomplete requests of strangers are limited in size, number and time.

The kind: input that a parser holds, or a state in which a client can make the server wait. Its members here: a header
without end, many headers, a target without end, trailers and chunk extensions without end, blank lines, pipelined
requests, a head that arrives slowly, a connection without a request, the rest of a body that was answered already, a
body of a handshake, and an answer that nobody reads.
"""

import asyncio
import contextlib
import socket

import pytest
import uvicorn
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from starlette.types import Receive, Scope, Send
from uvicorn.server import ServerState

from endpoints.http import http_protocol as module
from endpoints.http.connection_table import ConnectionTable
from endpoints.http.http_protocol import MAX_HEAD, MAX_LINES, MAX_PIPELINED, REST_OF_HEAD, DirectHttp, http_protocol
from endpoints.http.websocket_protocol import DirectWebSocket
from tests.support.endpoints.serving import serve

GET = b"GET /%s HTTP/1.1\r\nHost: here\r\n"
POST = b"POST / HTTP/1.1\r\nHost: here\r\n"
LARGE = 32 << 20


async def echo(scope: Scope, receive: Receive, send: Send) -> None:
    """Answer with the path and the body, ``/large`` is more than sockets hold, ``/wait`` takes a time."""
    assert scope["type"] == "http"
    read, more = b"", scope["method"] == "POST" and scope["path"] != "/early"
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            return
        read, more = read + message["body"], message["more_body"]
    if scope["path"] == "/wait":
        await asyncio.sleep(0.2)
    body = b"x" * LARGE if scope["path"] == "/large" else scope["path"].encode() + read
    names = b",".join(name for name, _ in scope["headers"])
    headers = [(b"content-length", b"%d" % len(body)), (b"x-names", names)]
    await send({"type": "http.response.start", "status": 200, "headers": headers})
    await send({"type": "http.response.body", "body": body})


@pytest.fixture(autouse=True)
def hurried(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "HEAD_SECONDS", 0.5)
    monkeypatch.setattr(module, "REST_SECONDS", 0.5)
    monkeypatch.setattr(module, "UNREAD_SECONDS", 0.5)


async def answers(port: int, *pieces: bytes) -> bytes:
    """Send these pieces one after the other; return what the server sends until it closes the connection."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    answer = bytearray()

    async def receive() -> None:
        with contextlib.suppress(ConnectionError):  # a server that closes while pieces arrive resets the connection
            while part := await reader.read(1 << 16):
                answer.extend(part)

    received = asyncio.create_task(receive())
    try:
        for piece in pieces:
            if received.done():
                break
            writer.write(piece)
            await asyncio.sleep(0.005)
        await received
        return bytes(answer)
    finally:
        received.cancel()
        writer.close()


def statuses(answer: bytes) -> list[int]:
    return [int(part[:3]) for part in answer.split(b"HTTP/1.1 ")[1:]]


LINES = b"".join(b"x-%d: a\r\n" % i for i in range(MAX_LINES))


@pytest.mark.parametrize(
    ("pieces", "status"),
    [
        ([GET % b"" + b"x: " + b"a" * MAX_HEAD * 2], 431),
        ([GET % b"" + b"x: ", *[b"a" * 5000] * 8], 431),
        ([GET % b"" + b"x" * MAX_HEAD], 431),
        ([b"GET /" + b"a" * MAX_HEAD], 431),
        ([b"A" * MAX_HEAD], 400),
        ([GET % b"" + LINES + b"\r\n"], 431),
        ([b"\r\n" * MAX_HEAD], 431),
        ([POST + b"Transfer-Encoding: chunked\r\n\r\n1;x=" + b"a" * MAX_HEAD, b"a" * MAX_HEAD], 431),
        ([POST + b"Transfer-Encoding: chunked\r\n\r\n0\r\nx: " + b"a" * MAX_HEAD, b"a" * MAX_HEAD], 431),
        ([POST + b"Transfer-Encoding: chunked\r\n\r\n0\r\n" + LINES], 431),
        ([GET % b"" + b"x: "], 408),
        ([b"GET /v1 HTT"], 408),
        ([b"GET / HTTP/1.1\r\n\r\n"], 400),
        ([GET % b"" + b"Host: there\r\n\r\n"], 400),
        ([b"GET / HTTP/2.0\r\nHost: here\r\n\r\n"], 505),
        ([b"GET / HTTP/1.0\r\nHost: h\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n"], 400),
        ([GET % b"" + b"Upgrade: websocket\r\nConnection: Upgrade\r\nContent-Length: 9\r\n\r\n"], 400),
        ([POST + b"Transfer-Encoding: chunked\r\n\r\nno number\r\n"], 400),
        ([b"\x16\x03\x01\x02\x00\x01\x00"], 400),
    ],
)
async def test_a_request_beyond_the_limits_is_refused_and_the_connection_closed(
    pieces: list[bytes], status: int
) -> None:
    async with serve(echo, http=DirectHttp) as port:
        answer = await answers(port, *pieces)
    assert statuses(answer) == [status]
    assert b"connection: close" in answer.lower()
    assert b"application/problem+json" in answer


async def test_a_head_within_the_limits_is_answered_in_any_pieces() -> None:
    start = GET % b"a" + b"Connection: close\r\nx: "
    head = start + b"a" * (MAX_HEAD - len(start) - 4) + b"\r\n\r\n"
    lines = GET % b"a" + LINES[: LINES.rindex(b"x-126")] + b"Connection: close\r\n\r\n"
    async with serve(echo, http=DirectHttp) as port:
        for pieces in ([head], [head[:9], head[9:20_000], head[20_000:]], [lines], [b"\r\n", lines]):
            assert statuses(await answers(port, *pieces)) == [200]


async def test_a_connection_without_a_request_is_closed_without_an_answer() -> None:
    async with serve(echo, http=DirectHttp) as port:
        assert await answers(port) == b""
        assert await answers(port, b"\r\n") == b""


async def test_a_head_that_arrives_letter_by_letter_is_not_waited_for() -> None:
    async with serve(echo, http=DirectHttp) as port:
        assert statuses(await answers(port, GET % b"" + b"x: ", *[b"a"] * 10_000)) == [408]


async def test_a_slow_head_after_a_request_is_refused_and_trailers_are_dropped() -> None:
    async with serve(echo, http=DirectHttp) as port:
        chunked = POST + b"Transfer-Encoding: chunked\r\n\r\n1\r\na\r\n0\r\nAuthorization: me\r\n\r\n"
        answer = await answers(port, chunked, GET % b"next" + b"x: ")
        assert statuses(answer) == [200, 408]
        assert b"x-names: host,transfer-encoding\r\n" in answer


async def test_few_pipelined_requests_are_answered_and_many_are_cut() -> None:
    async with serve(echo, http=DirectHttp) as port:
        few = b"".join(GET % b"%d" % i + b"\r\n" for i in range(MAX_PIPELINED))
        answer = await answers(port, few + GET % b"last" + b"Connection: close\r\n\r\n")
        assert statuses(answer) == [200] * (MAX_PIPELINED + 1)
        assert answer.endswith(b"/last")
        many = (GET % b"wait" + b"\r\n") + (GET % b"" + b"\r\n") * 5000
        assert statuses(await answers(port, many)) == [200] * (MAX_PIPELINED + 1)


async def test_an_invalid_request_is_not_answered_in_the_place_of_the_one_before() -> None:
    async with serve(echo, http=DirectHttp) as port:
        answer = await answers(port, GET % b"wait" + b"\r\n", b"no request\r\n")
        assert statuses(answer) == [200]
        assert answer.endswith(b"/wait")


async def test_the_rest_of_an_answered_body_is_dropped_for_a_time() -> None:
    early = b"POST /early HTTP/1.1\r\nHost: here\r\nContent-Length: 3000000\r\n\r\n"
    async with serve(echo, http=DirectHttp) as port:
        complete = early + b"x" * 3_000_000 + GET % b"next" + b"Connection: close\r\n\r\n"
        assert statuses(await answers(port, complete)) == [200, 200]
        assert statuses(await answers(port, early, *[b"x"] * 2_000)) == [200]


async def test_what_follows_a_refusal_is_dropped_up_to_a_limit() -> None:
    async with serve(echo, http=DirectHttp) as port:
        _reader, writer = await asyncio.open_connection("127.0.0.1", port)
        with pytest.raises(ConnectionError):
            for _ in range(1000):
                writer.write(b"a" * (1 << 20))
                await writer.drain()
        writer.close()
        assert statuses(await answers(port, GET % b"" + b"x: " + b"a" * (MAX_HEAD + REST_OF_HEAD // 2))) == [431]


@pytest.mark.parametrize("size", [15, 40, 10_000])
@pytest.mark.parametrize(
    "body", [b"Content-Length: 3\r\n\r\nabc", b"Transfer-Encoding: chunked\r\n\r\n2\r\nab\r\n1\r\nc\r\n0\r\n\r\n"]
)
async def test_an_offer_of_another_protocol_is_ignored(body: bytes, size: int) -> None:
    offer = b"Upgrade: h2c\r\nConnection: Upgrade, HTTP2-Settings\r\nHTTP2-Settings: AAMAAABkAAQAoAAAAAIAAAAA\r\n"
    sent = POST + offer + body + GET % b"next" + b"Connection: close\r\n\r\n"
    async with serve(echo, http=DirectHttp) as port:
        answer = await answers(port, *(sent[at : at + size] for at in range(0, len(sent), size)))
    assert statuses(answer) == [200, 200]
    assert b"/abc" in answer
    assert b"upgrade" not in answer


async def test_an_answer_that_nobody_reads_is_given_up() -> None:
    table = ConnectionTable()
    async with serve(echo, http=http_protocol(table)) as port:
        with socket.create_connection(("127.0.0.1", port)) as silent:
            silent.sendall(GET % b"large" + b"\r\n")
            while not len(table):
                await asyncio.sleep(0.01)
            while len(table):
                await asyncio.sleep(0.01)


async def test_connections_that_wait_make_room_for_new_ones() -> None:
    async with serve(echo, http=http_protocol(ConnectionTable(3, 3))) as port:
        silent = [await asyncio.open_connection("127.0.0.1", port) for _ in range(3)]
        assert statuses(await answers(port, GET % b"a" + b"Connection: close\r\n\r\n")) == [200]
        assert await silent[0][0].read() == b""
        for _, writer in silent:
            writer.close()


async def test_hundreds_of_half_open_connections_are_not_noticed_by_others(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "HEAD_SECONDS", 60.0)
    table = ConnectionTable(400, 300)
    async with serve(echo, http=http_protocol(table)) as port:
        with contextlib.ExitStack() as half_open:
            for number in range(500):
                client = half_open.enter_context(socket.create_connection(("127.0.0.1", port)))
                if number % 2:
                    client.sendall(GET % b"never")
                if number % 50 == 0:
                    assert statuses(await answers(port, GET % b"" + b"Connection: close\r\n\r\n")) == [200]
            for _ in range(5):
                assert statuses(await answers(port, GET % b"" + b"Connection: close\r\n\r\n")) == [200]
            assert 250 < len(table) <= 300


async def test_a_connection_beyond_the_limit_is_told_so() -> None:
    table = ConnectionTable(1, 1)
    async with serve(echo, http=http_protocol(table)) as port:
        first = asyncio.create_task(answers(port, GET % b"wait" + b"Connection: close\r\n\r\n"))
        while not len(table):
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.05)
        refused = await answers(port, b"")
        assert statuses(refused) == [503]
        assert statuses(await first) == [200]
        while len(table):
            await asyncio.sleep(0.01)
        assert statuses(await answers(port, GET % b"" + b"Connection: close\r\n\r\n")) == [200]


def mutations() -> st.SearchStrategy[bytes]:
    """Return requests with bytes changed, dropped or put in."""
    requests = st.sampled_from(
        [
            GET % b"a?b=c" + b"\r\n",
            GET % b"" + b"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\r\n",
            POST + b"Content-Length: 3\r\n\r\nabc",
            POST + b"Transfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n0\r\nx: y\r\n\r\n",
            b"CONNECT a:1 HTTP/1.1\r\nHost: a\r\n\r\n",
            b"OPTIONS * HTTP/1.1\r\nHost: a\r\n\r\n",
            b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        ]
    )

    def changed(data: bytes, changes: list[tuple[int, int, bytes]]) -> bytes:
        for at, drop, put in changes:
            data = data[:at] + put + data[at + drop :]
        return data

    change = st.tuples(
        st.integers(0, 80), st.integers(0, 3), st.binary(max_size=2) | st.sampled_from([b"\r\n", b": ", b"\0", b"\xff"])
    )
    return st.lists(st.builds(changed, requests, st.lists(change, max_size=3)), min_size=1, max_size=3).map(b"".join)


class FakeTransport(asyncio.Transport):
    """Transport that notes what was done with it."""

    def __init__(self) -> None:
        super().__init__()
        self.closed = False
        self.protocol: asyncio.BaseProtocol | None = None

    def write(self, data: bytes | bytearray | memoryview) -> None:
        pass

    def close(self) -> None:
        self.closed = True

    abort = close

    def is_closing(self) -> bool:
        return self.closed

    def can_write_eof(self) -> bool:
        return True

    def write_eof(self) -> None:
        pass

    def pause_reading(self) -> None:
        pass

    resume_reading = pause_reading

    def set_protocol(self, protocol: asyncio.BaseProtocol) -> None:
        self.protocol = protocol

    def get_protocol(self) -> asyncio.BaseProtocol:
        assert self.protocol is not None
        return self.protocol


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(mutations(), st.lists(st.integers(1, 60), max_size=4))
async def test_any_bytes_are_answered_or_refused_in_bounded_memory(data: bytes, sizes: list[int]) -> None:
    config = uvicorn.Config(echo, ws=DirectWebSocket, lifespan="off")
    transport = FakeTransport()
    protocol = http_protocol(ConnectionTable())(config=config, server_state=ServerState(), app_state={})
    transport.protocol = protocol
    protocol.connection_made(transport)
    for size in [*sizes, len(data)]:
        if transport.protocol is protocol and not transport.closed:
            protocol.data_received(data[:size])
        data = data[size:]
    assert protocol._deaf or protocol._stalled < MAX_HEAD
    assert len(protocol.pipeline) <= MAX_PIPELINED
    transport.get_protocol().connection_lost(None)
    await asyncio.gather(*protocol.tasks, return_exceptions=True)
    assert len(protocol.table) == 0
