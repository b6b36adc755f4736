"""A container reaches the endpoints that it names through its machine, and nothing else."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import msgspec
import pytest

from engine.agent.relays import EndpointRelay
from engine.protocols.address import RELAY, EndpointAddress, UnixAddress, endpoint_socket
from engine.protocols.sockets import Streams, dial, listen
from tests.support.waiting import patience

HERE = "hall"
FAR = EndpointAddress("elsewhere", "unix:/of/another/host.sock", "tls://cloud.example:40001", "f1")


async def _echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while data := await reader.read(1 << 16):
        writer.write(data)
    writer.close()


@asynccontextmanager
async def relay(folder: Path, dialled: list[EndpointAddress]) -> AsyncIterator[EndpointRelay]:
    """Run a relay, and an endpoint that echoes; an address of another host leads to the same endpoint."""
    endpoint = UnixAddress(endpoint_socket(folder, "hall-1"))
    server = await listen(endpoint, _echo)

    async def dial_far(at: EndpointAddress) -> Streams:
        dialled.append(at)
        return await dial(endpoint)

    opened = EndpointRelay(folder / RELAY, HERE, folder, dial_far)
    await opened.start()
    try:
        yield opened
    finally:
        await opened.close()
        server.close()


async def exchange(opened: EndpointRelay, line: bytes) -> bytes:
    """Name an endpoint as a container does, send a word, and return what comes back."""
    reader, writer = await asyncio.open_unix_connection(opened.path)
    writer.write(line + b"\nhello")
    try:
        async with patience(10.0):
            return await reader.read(5)
    except ConnectionError:
        return b""
    finally:
        writer.close()


async def test_an_endpoint_of_this_machine_is_dialled_at_its_socket(short_path: Path) -> None:
    near, dialled = str(UnixAddress(endpoint_socket(short_path, "hall-1"))), list[EndpointAddress]()
    async with relay(short_path, dialled) as opened:
        named = EndpointAddress(HERE, near, "tls://hall.example:40002")
        assert await exchange(opened, msgspec.json.encode(named)) == b"hello"
    assert dialled == []


async def test_an_endpoint_of_another_machine_is_dialled_at_its_address_for_others(short_path: Path) -> None:
    dialled = list[EndpointAddress]()
    async with relay(short_path, dialled) as opened:
        assert await exchange(opened, msgspec.json.encode(FAR)) == b"hello"
    assert dialled == [FAR]


@pytest.mark.parametrize(
    "line",
    [
        '{"machine":"hall","near":"unix:/var/run/docker.sock"}',
        '{"machine":"hall","near":"unix:FOLDER/control.sock"}',
        '{"machine":"hall","near":"unix:FOLDER/../endpoint-x.sock"}',
        '{"machine":"hall","near":"tls://elsewhere.example:1"}',
        '{"machine":"elsewhere","near":"unix:FOLDER/endpoint-hall-1.sock"}',
        '{"machine":"hall"}',
        "nonsense",
        "\udcff",
    ],
)
async def test_other_addresses_are_refused(short_path: Path, line: str, caplog: pytest.LogCaptureFixture) -> None:
    dialled = list[EndpointAddress]()
    async with relay(short_path, dialled) as opened:
        text = line.replace("FOLDER", str(short_path)).encode("utf-8", "surrogateescape")
        assert await exchange(opened, text) == b""
    assert dialled == []
    assert "could not connect" in caplog.text
