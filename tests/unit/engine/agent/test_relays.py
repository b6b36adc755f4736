"""Relays: containers reach the master and the endpoints that they name through their machine, and nothing else.

Both ends are real Unix sockets, instead of a socket and a TLS connection.
"""

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator, Awaitable
from contextlib import asynccontextmanager
from pathlib import Path

import msgspec
import pytest

from engine.agent.relays import EndpointRelay, RobotLinkRelay
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
async def endpoint_relay(folder: Path, dialled: list[EndpointAddress]) -> AsyncIterator[EndpointRelay]:
    """Run a endpoint_relay, and an endpoint that echoes; an address of another host leads to the same endpoint."""
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
    async with endpoint_relay(short_path, dialled) as opened:
        named = EndpointAddress(HERE, near, "tls://hall.example:40002")
        assert await exchange(opened, msgspec.json.encode(named)) == b"hello"
    assert dialled == []


async def test_an_endpoint_of_another_machine_is_dialled_at_its_address_for_others(short_path: Path) -> None:
    dialled = list[EndpointAddress]()
    async with endpoint_relay(short_path, dialled) as opened:
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
    async with endpoint_relay(short_path, dialled) as opened:
        text = line.replace("FOLDER", str(short_path)).encode("utf-8", "surrogateescape")
        assert await exchange(opened, text) == b""
    assert dialled == []
    assert "could not connect" in caplog.text


class Endpoint:
    """Endpoint that echoes what it receives, until it receives ``end``."""

    def __init__(self, path: Path) -> None:
        self.address = UnixAddress(path)
        self.gone = asyncio.Event()

    async def start(self) -> None:
        self.server = await listen(self.address, self._connected)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(1 << 16):
                writer.write(data)
                await writer.drain()
                if data.endswith(b"end"):
                    break
        writer.close()
        self.gone.set()


@pytest.fixture
async def endpoint(tmp_path: Path) -> AsyncIterator[Endpoint]:
    opened = Endpoint(tmp_path / "far.sock")
    await opened.start()
    yield opened
    opened.server.close()


@pytest.fixture
async def relay(tmp_path: Path, endpoint: Endpoint) -> AsyncIterator[RobotLinkRelay]:
    opened = RobotLinkRelay(tmp_path / "near.sock", lambda _: dial(endpoint.address), lambda: "here")
    await opened.start()
    yield opened
    await opened.close()


async def test_data_and_its_answer_arrive_whole(relay: RobotLinkRelay) -> None:
    reader, writer = await dial(UnixAddress(relay.path))
    data = os.urandom(3 << 20)
    writer.write(data)
    async with patience(10.0):
        assert await reader.readexactly(len(data)) == data
    writer.close()


async def test_endpoint_sees_the_container_disconnect(relay: RobotLinkRelay, endpoint: Endpoint) -> None:
    _, writer = await dial(UnixAddress(relay.path))
    writer.write(b"x")
    writer.close()
    async with patience(10.0):
        await endpoint.gone.wait()


async def test_container_receives_everything_before_the_endpoint_closes(relay: RobotLinkRelay) -> None:
    reader, writer = await dial(UnixAddress(relay.path))
    writer.write(b"the end")
    async with patience(10.0):
        assert await reader.read() == b"the end"
    writer.close()


async def test_container_is_disconnected_if_the_endpoint_is_unreachable(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    relay = RobotLinkRelay(
        tmp_path / "near.sock", lambda _: dial(UnixAddress(tmp_path / "nobody.sock")), lambda: "here"
    )
    await relay.start()
    reader, writer = await dial(UnixAddress(relay.path))
    async with patience(10.0):
        assert await reader.read() == b""
    assert "could not connect to its endpoint" in caplog.text
    writer.close()
    await relay.close()


async def test_closing_disconnects_both_ends_and_removes_the_socket(relay: RobotLinkRelay, endpoint: Endpoint) -> None:
    reader, writer = await dial(UnixAddress(relay.path))
    writer.write(b"x")
    assert await reader.read(1) == b"x"
    await relay.close()
    async with patience(10.0):
        await endpoint.gone.wait()
    assert not relay.path.exists()
    writer.close()


async def test_connections_to_an_endpoint_that_leads_no_more_are_aborted(tmp_path: Path, endpoint: Endpoint) -> None:
    where, dialled = ["first"], []

    def dial_there(address: str) -> Awaitable[Streams]:
        dialled.append(address)
        return dial(endpoint.address)

    relay = RobotLinkRelay(tmp_path / "near.sock", dial_there, lambda: where[0])
    await relay.start()
    try:
        left, left_writer = await dial(UnixAddress(relay.path))
        left_writer.write(b"data")
        assert await left.readexactly(4) == b"data"
        where[0] = "second"
        kept, kept_writer = await dial(UnixAddress(relay.path))
        kept_writer.write(b"data")
        assert await kept.readexactly(4) == b"data"
        relay.leave_others()
        async with patience(10.0):
            with contextlib.suppress(ConnectionError):
                assert await left.read() == b""
        kept_writer.write(b"more")
        assert await kept.readexactly(4) == b"more"
        assert dialled == ["first", "second"]
    finally:
        await relay.close()
