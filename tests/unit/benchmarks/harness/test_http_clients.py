"""HTTP clients of benches."""

import asyncio
import itertools
from collections.abc import AsyncIterator

import pytest

from benchmarks.harness.plan_calls import RouteRequests
from ppaas.errors import Unavailable


class Server:
    """Server that answers each request with its own body, in pieces."""

    def __init__(self) -> None:
        self.heads: list[bytes] = []
        self.status = b"201 Created"
        self.hangs_up = False

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            while not self.hangs_up:
                head = await reader.readuntil(b"\r\n\r\n")
                self.heads.append(head)
                body = await reader.readexactly(int(head.rpartition(b":")[2]))
                writer.write(b"HTTP/1.1 %b\r\nContent-Length: %d\r\n\r\n%b" % (self.status, len(body), body[:2]))
                await asyncio.sleep(0.001)
                writer.write(body[2:])
        except asyncio.IncompleteReadError:
            pass
        writer.close()


@pytest.fixture
async def server() -> AsyncIterator[tuple[Server, str]]:
    made = Server()
    async with await asyncio.start_server(made.serve, "127.0.0.1", 0) as listening:
        yield made, f"http://127.0.0.1:{listening.sockets[0].getsockname()[1]}/paths?poses=rows"


async def test_clients_share_the_requests(server: tuple[Server, str]) -> None:
    made, url = server
    requests = RouteRequests(url, "secret", (b"x" * size for size in range(1, 31)), {"Accept": "text/plain"})
    await requests.run(4)
    assert (len(made.heads), requests.size) == (30, sum(range(1, 31)))
    assert requests.answers[0] == b"x"
    assert len(requests.answers) == 2
    assert made.heads[0].startswith(b"POST /paths?poses=rows HTTP/1.1\r\n")
    assert b"Authorization: Bearer secret\r\n" in made.heads[0]
    assert b"Accept: text/plain\r\n" in made.heads[0]


async def test_more_clients_than_requests_end(server: tuple[Server, str]) -> None:
    made, url = server
    await RouteRequests(url, "t", iter([b"body"])).run(5)
    assert len(made.heads) == 1


@pytest.mark.parametrize("fault", ["refuses", "hangs up"])
async def test_a_server_that_refuses_or_hangs_up_is_reported(server: tuple[Server, str], fault: str) -> None:
    made, url = server
    made.status, made.hangs_up = b"503 Service Unavailable", fault == "hangs up"
    with pytest.raises(ExceptionGroup) as failed:
        await RouteRequests(url, "t", itertools.repeat(b"body")).run(1)
    [error] = failed.value.exceptions
    assert isinstance(error, Unavailable)
    assert ("503" in str(error)) == (fault == "refuses")
