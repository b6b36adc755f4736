"""Posts over real sockets: addresses that are refused where they are connected to, redirects, silence."""

import asyncio
import socket
from collections.abc import Callable
from typing import Any

import pytest

from endpoints.webhooks.posting import LONGEST_WAIT, Poster
from endpoints.webhooks.targets import TargetRules
from ppaas.errors import NotPermitted, Unavailable
from tests.support.endpoints.webhook_target import Target

ALLOWED = TargetRules(allow_private=True, allow_http=True)
HEADERS = {"webhook-id": "msg_1", "Content-Type": "application/json"}


@pytest.fixture
def resolved(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Let names resolve to addresses of the test, as the loop has it."""

    def to(*addresses: str) -> None:
        async def getaddrinfo(_loop: Any, _host: str, port: int, **_options: Any) -> list[Any]:
            return [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (address, port)) for address in addresses]

        monkeypatch.setattr(type(asyncio.get_running_loop()), "getaddrinfo", getaddrinfo)

    return to


async def test_a_target_gets_the_body_and_the_headers_once() -> None:
    async with Target().serving() as target:
        answer = await Poster(ALLOWED).post(target.url, HEADERS, b"{}")
    assert (answer.status, answer.wait) == (204, 0.0)
    assert target.ids == {"msg_1": 1}


async def test_a_redirect_is_an_answer_and_is_not_followed() -> None:
    async with Target(status=lambda _: 307).serving() as target:
        assert (await Poster(ALLOWED).post(target.url, HEADERS, b"{}")).status == 307
    assert target.ids.total() == 1


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "2130706433", "0x7f.1"])
async def test_an_address_that_is_not_public_is_not_connected_to(host: str) -> None:
    async with Target().serving() as target:
        with pytest.raises(NotPermitted, match="no public address"):
            await Poster(TargetRules(allow_http=True)).post(f"http://{host}:{target.port}/", HEADERS, b"{}")
    assert target.ids.total() == 0


async def test_a_name_is_checked_at_each_connection(resolved: Callable[..., None]) -> None:
    async with Target().serving() as target:
        url = f"http://target.example:{target.port}/"
        resolved("127.0.0.1")
        assert (await Poster(ALLOWED).post(url, HEADERS, b"{}")).status == 204
        with pytest.raises(NotPermitted, match=r"target\.example has no public address"):
            await Poster(TargetRules(allow_http=True)).post(url, HEADERS, b"{}")
    assert target.ids.total() == 1


async def test_the_next_address_is_tried_if_one_does_not_answer(resolved: Callable[..., None]) -> None:
    async with Target().serving() as target:
        resolved("127.0.0.2", "127.0.0.1")
        assert (await Poster(ALLOWED).post(f"http://a.b:{target.port}/", HEADERS, b"{}")).status == 204


async def test_a_target_that_hangs_is_given_up() -> None:
    async with Target(hangs=True).serving() as target:
        with pytest.raises(Unavailable, match=r"no answer within 0\.1 s"):
            await Poster(ALLOWED, timeout=0.1).post(target.url, HEADERS, b"{}")
        target.hangs = False


async def test_a_target_that_is_away_or_speaks_no_http_is_reported() -> None:
    async with Target().serving() as target:
        with pytest.raises(Unavailable, match="no answer"):
            await Poster(ALLOWED).post(target.url.replace("http:", "https:"), HEADERS, b"{}")
        url = target.url
    with pytest.raises(Unavailable, match="no answer"):
        await Poster(ALLOWED).post(url, HEADERS, b"{}")


@pytest.mark.parametrize(("value", "wait"), [("7", 7.0), ("9" * 12, LONGEST_WAIT), ("soon", 0.0), ("-1", 0.0)])
async def test_a_target_may_ask_to_wait(value: str, wait: float) -> None:
    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(f"HTTP/1.1 503 Busy\r\nRetry-After: {value}\r\nContent-Length: 0\r\n\r\n".encode())
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(answer, "127.0.0.1", 0)
    async with server:
        port = server.sockets[0].getsockname()[1]
        assert await Poster(ALLOWED).post(f"http://127.0.0.1:{port}/", HEADERS, b"{}") == (503, wait)
