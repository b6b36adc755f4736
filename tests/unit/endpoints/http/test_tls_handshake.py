"""A connection is bounded before its TLS handshake is complete.

Its members: a client that sends nothing, one that sends something other than TLS, one that stops in the middle, one
that closes, one that sends its request with the end of the handshake, and more of them than the table allows.
"""

import asyncio
import socket
import ssl
from collections.abc import AsyncIterator
from pathlib import Path
from typing import cast

import pytest

from endpoints.http import tls
from endpoints.http.connection_table import ConnectionTable
from endpoints.http.tls import HandshakeListener, ServerTls
from tests.support.network.certificates import TestAuthority
from tests.support.waiting import patience, until


class Echo(asyncio.Protocol):
    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast(asyncio.Transport, transport)

    def data_received(self, data: bytes) -> None:
        self.transport.write(data)


@pytest.fixture
def authority(tmp_path: Path) -> TestAuthority:
    return TestAuthority(tmp_path)


@pytest.fixture
def table() -> ConnectionTable:
    return ConnectionTable(3, 3)


@pytest.fixture
async def port(authority: TestAuthority, table: ConnectionTable) -> AsyncIterator[int]:
    context = ServerTls(*authority.issue("cloud")).context
    with socket.create_server(("127.0.0.1", 0)) as listener:
        accepting = asyncio.create_task(HandshakeListener(listener, context, table, Echo).run())
        yield listener.getsockname()[1]
        accepting.cancel()
        await asyncio.gather(accepting, return_exceptions=True)
    await until(lambda: len(table) == 0)


async def is_closed(reader: asyncio.StreamReader) -> bool:
    """Wait until the server closes a connection."""
    async with patience(30):
        try:
            while await reader.read(1 << 16):
                pass
        except ConnectionError:
            pass
    return True


async def test_a_client_is_served_after_its_handshake(
    port: int, table: ConnectionTable, authority: TestAuthority
) -> None:
    for _ in range(5):
        context = ssl.create_default_context(cafile=authority.file)
        reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=context)
        writer.write(b"at once\n")
        assert await reader.readline() == b"at once\n"
        assert len(table) == 0  # the protocol above counts it
        writer.close()


@pytest.mark.parametrize("sent", [b"", b"GET / HTTP/1.1\r\n\r\n", b"\x16\x03\x01\x02\x00\x01"])
async def test_a_client_without_a_handshake_is_closed(
    port: int, table: ConnectionTable, monkeypatch: pytest.MonkeyPatch, sent: bytes
) -> None:
    monkeypatch.setattr(tls, "HANDSHAKE_SECONDS", 0.2)
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(sent)
    assert await is_closed(reader)
    await until(lambda: len(table) == 0)
    writer.close()


async def test_a_client_that_closes_is_counted_no_more(port: int, table: ConnectionTable) -> None:
    _, writer = await asyncio.open_connection("127.0.0.1", port)
    await until(lambda: len(table) == 1)
    writer.close()
    await until(lambda: len(table) == 0)


async def test_silent_clients_make_room_for_others(port: int, table: ConnectionTable, authority: TestAuthority) -> None:
    silent = [await asyncio.open_connection("127.0.0.1", port) for _ in range(3)]
    await until(lambda: len(table) == 3)
    context = ssl.create_default_context(cafile=authority.file)
    reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=context)
    writer.write(b"served\n")
    assert await reader.readline() == b"served\n"
    assert await is_closed(silent[0][0])
    for _, each in [*silent, (reader, writer)]:
        each.close()
