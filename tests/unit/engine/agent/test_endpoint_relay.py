"""A container reaches the endpoints that it names through its machine, and nothing else."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from engine.agent.relays.endpoint_relay import EndpointRelay
from engine.protocols.address import UnixAddress, parse_address
from engine.protocols.endpoint_sockets import RELAY, endpoint_socket
from engine.protocols.sockets import Streams, dial, listen

FAR = "tls://cloud.example:40001"


async def _echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while data := await reader.read(1 << 16):
        writer.write(data)
    writer.close()


@asynccontextmanager
async def relay(folder: Path, dialled: list[str], *, is_far: bool) -> AsyncIterator[EndpointRelay]:
    """Run a relay, and an endpoint that echoes; an address of another host leads to the same endpoint."""
    endpoint = UnixAddress(endpoint_socket(folder, "local-1"))
    server = await listen(endpoint, _echo)

    async def dial_endpoint(address: str) -> Streams:
        dialled.append(address)
        return await dial(endpoint if address == FAR else parse_address(address))

    opened = EndpointRelay(folder / RELAY, dial_endpoint, is_far=is_far)
    await opened.start()
    try:
        yield opened
    finally:
        await opened.close()
        server.close()


async def exchange(opened: EndpointRelay, line: str) -> bytes:
    """Name an endpoint as a container does, send a word, and return what comes back."""
    reader, writer = await asyncio.open_unix_connection(opened.path)
    writer.write(line.encode() + b"\nhello")
    try:
        async with asyncio.timeout(10.0):
            return await reader.read(5)
    except ConnectionError:
        return b""
    finally:
        writer.close()


@pytest.mark.parametrize("is_far", [False, True])
async def test_the_address_for_its_host_is_dialled(short_path: Path, is_far: bool) -> None:
    near, dialled = str(UnixAddress(endpoint_socket(short_path, "local-1"))), list[str]()
    async with relay(short_path, dialled, is_far=is_far) as opened:
        assert await exchange(opened, f"{near} {FAR}") == b"hello"
    assert dialled == [FAR if is_far else near]


@pytest.mark.parametrize(
    ("is_far", "line"),
    [
        (False, "unix:/var/run/docker.sock "),
        (False, "unix:{folder}/control.sock "),
        (False, "unix:{folder}/../endpoint-x.sock "),
        (False, "tls://elsewhere.example:1 "),
        (False, "nonsense"),
        (False, "\udcff"),
        (True, "unix:{folder}/endpoint-local-1.sock "),
    ],
)
async def test_other_addresses_are_refused(
    short_path: Path, is_far: bool, line: str, caplog: pytest.LogCaptureFixture
) -> None:
    dialled = list[str]()
    async with relay(short_path, dialled, is_far=is_far) as opened:
        text = line.format(folder=short_path).encode("utf-8", "surrogateescape").decode("latin-1")
        assert await exchange(opened, text) == b""
    assert dialled == []
    assert "could not connect" in caplog.text
