"""Bodies reach the application complete in any chunking, and blocks of large bodies are not copied."""

import asyncio
import hashlib
from collections.abc import Iterator
from typing import Any

import pytest
from starlette.types import Receive, Scope, Send

from endpoints.http.http_protocol import BadHead, DirectHttp, check_head
from tests.support.endpoints.serving import serve

HEAD = b"POST /%d HTTP/1.1\r\nHost: here\r\nContent-Length: %d\r\n\r\n"


async def digest(scope: Scope, receive: Receive, send: Send) -> None:
    """Answer with the hash of the body."""
    sha, more = hashlib.sha256(), True
    while more:
        message = await receive()
        assert type(message["body"]) is bytes
        sha.update(message["body"])
        more = message["more_body"]
    encoded = sha.hexdigest().encode()
    headers = [(b"content-length", str(len(encoded)).encode())]
    await send({"type": "http.response.start", "status": 200, "headers": headers})
    await send({"type": "http.response.body", "body": encoded})


def pieces(data: bytes, size: int) -> Iterator[bytes]:
    return (data[at : at + size] for at in range(0, len(data), size))


@pytest.mark.parametrize("size", [1, 50_000, 3_000_000])
async def test_bodies_sent_in_pieces_arrive_complete(size: int) -> None:
    bodies = [bytes(range(256)) * (count * min(size, 40)) for count in (0, 1, 3, 700)]
    async with serve(digest, http=DirectHttp) as port:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        for number, body in enumerate(bodies):
            for piece in pieces(HEAD % (number, len(body)) + body[:2000], size):
                writer.write(piece)
            for piece in pieces(body[2000:], max(size, 1000)):
                writer.write(piece)
            await writer.drain()
            answer = await reader.readuntil(b"\r\n\r\n")
            assert answer.startswith(b"HTTP/1.1 200")
            assert await reader.readexactly(64) == hashlib.sha256(body).hexdigest().encode()
        writer.close()
        await writer.wait_closed()


async def test_the_first_body_block_is_not_copied() -> None:
    class Cycle:
        body: Any = bytearray()
        response_complete = False
        message_event = asyncio.Event()

    class Parser:
        def should_upgrade(self) -> bool:
            return False

    protocol = DirectHttp.__new__(DirectHttp)
    protocol.cycle, protocol.parser, protocol._progress = Cycle(), Parser(), 0  # type: ignore[assignment]
    block = b"block" * 1000
    protocol.on_body(block)
    assert bytes(protocol.cycle.body) is block
    protocol.on_body(b" and more")
    assert bytes(protocol.cycle.body) == block + b" and more"


HOST = (b"host", b"cloud:8500")


# Rules of the head of a request: its version, and its Host.


@pytest.mark.parametrize(
    ("version", "headers", "websocket", "status"),
    [
        ("1.1", [HOST], False, None),
        ("1.1", [(b"host", b"")], False, None),
        ("1.1", [(b"host", b"[::1]:8500 ")], False, None),
        ("1.1", [(b"host", b"my_robot.lab")], False, None),
        ("1.0", [], False, None),
        ("1.0", [HOST], False, None),
        ("1.1", [HOST], True, None),
        ("1.1", [], False, 400),
        ("1.1", [HOST, HOST], False, 400),
        ("1.0", [HOST, (b"host", b"other")], False, 400),
        ("1.1", [(b"host", b"a b")], False, 400),
        ("1.1", [(b"host", b"a/b")], False, 400),
        ("1.1", [(b"host", b"a@b")], False, 400),
        ("1.1", [(b"host", b"a\xff")], False, 400),
        ("1.0", [HOST], True, 400),
        ("0.9", [HOST], False, 505),
        ("2.0", [HOST], False, 505),
        ("1.1", [HOST, (b"content-length", b"5")], True, 400),
        ("1.1", [HOST, (b"transfer-encoding", b"chunked")], True, 400),
        ("1.1", [HOST, (b"content-length", b"0")], True, None),
    ],
)
def test_a_head_is_accepted_or_refused_with_a_status(
    version: str, headers: list[tuple[bytes, bytes]], websocket: bool, status: int | None
) -> None:
    if status is None:
        check_head(version, headers, websocket=websocket)
    else:
        with pytest.raises(BadHead) as refused:
            check_head(version, headers, websocket=websocket)
        assert refused.value.status == status
