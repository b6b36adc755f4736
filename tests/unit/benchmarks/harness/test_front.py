"""Proxy before a leader and its standby, over real sockets."""

import asyncio
import contextlib
import socket
from collections.abc import AsyncIterator

import pytest

from benchmarks.harness import free_ports as module
from benchmarks.harness import front
from benchmarks.harness.free_ports import END, LOWEST, free_ports
from benchmarks.harness.front import Front
from robots.client.rest import RestClient
from tests.support.waiting import until


class Cloud:
    """Server that answers each request with its name, and may say that it is not ready."""

    def __init__(self, name: str) -> None:
        self._name = name
        self.ready = True

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        head = await reader.readuntil(b"\r\n\r\n")
        status = "200 OK" if self.ready or b"/ready" not in head else "503 Service Unavailable"
        body = f'{{"ready":{str(self.ready).lower()},"of":"{self._name}"}}'
        writer.write(f"HTTP/1.1 {status}\r\nContent-Length: {len(body)}\r\n\r\n{body}".encode())
        writer.close()


@contextlib.asynccontextmanager
async def clouds(*ports: int) -> AsyncIterator[list[Cloud]]:
    made = [Cloud(f"cloud {number}") for number in range(len(ports))]
    servers = [
        await asyncio.start_server(cloud.serve, "127.0.0.1", port) for cloud, port in zip(made, ports, strict=True)
    ]
    yield made
    for server in servers:
        server.close()


async def test_new_connections_reach_the_cloud_that_is_ready(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(front, "PERIOD", 0.02)
    ports = free_ports(2)
    before = Front(ports)
    async with clouds(*ports) as (first, second), before.serving():
        second.ready = False
        await before.is_ready()
        rest = RestClient(before.url)
        assert (await rest.get("/v1/robots"))["of"] == "cloud 0"
        first.ready, second.ready = False, True
        await until(lambda: before.changes == 1)
        assert (await rest.get("/v1/robots"))["of"] == "cloud 1"
        second.ready = False
        await asyncio.sleep(0.1)
        assert before.changes == 1, "none is ready, so connections go where they went"
        first.ready = True
        await until(lambda: before.changes == 2)
        assert (await rest.get("/v1/robots"))["of"] == "cloud 0"


def test_consecutive_free_ports_are_returned() -> None:
    ports = free_ports(3)
    assert ports == list(range(ports[0], ports[0] + 3))
    assert ports[0] >= LOWEST and ports[-1] < END
    for port in ports:
        with socket.create_server(("127.0.0.1", port)):
            pass


def test_a_range_with_a_port_in_use_is_skipped(monkeypatch) -> None:
    first = free_ports(4)[0]
    places = iter([first - LOWEST, first - LOWEST + 2])
    monkeypatch.setattr(module.secrets, "randbelow", lambda _: next(places))
    with socket.create_server(("127.0.0.1", first + 1)):
        assert free_ports(2) == [first + 2, first + 3]
