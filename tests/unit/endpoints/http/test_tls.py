"""TLS of the web server.

Kinds of files that cannot be used: missing, not PEM, a key of another certificate, an encrypted key; at the start, and
when they are replaced.
"""

import asyncio
import logging
import socket
import ssl
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.serialization import BestAvailableEncryption, Encoding, PrivateFormat

from endpoints.http.tls import ServerTls, warn_if_open_to_others
from engine.remote.authority import read_key
from ppaas.errors import InvalidInput
from tests.support.network.certificates import TestAuthority
from tests.support.waiting import patience


@pytest.fixture
def authority(tmp_path: Path) -> TestAuthority:
    return TestAuthority(tmp_path)


@asynccontextmanager
async def echo_server(tls: ServerTls) -> AsyncIterator[int]:
    async def echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while line := await reader.readline():
            writer.write(line)
        writer.close()

    server = await asyncio.start_server(echo, "127.0.0.1", 0, ssl=tls.context)
    async with server:
        yield server.sockets[0].getsockname()[1]


async def connect(
    port: int, authority: TestAuthority, most: ssl.TLSVersion = ssl.TLSVersion.MAXIMUM_SUPPORTED
) -> tuple[asyncio.StreamReader, asyncio.StreamWriter, bytes]:
    """Return the streams of a connection, and the certificate of the server."""
    context = ssl.create_default_context(cafile=authority.file)
    context.maximum_version = most
    reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=context)
    certificate: bytes = writer.get_extra_info("ssl_object").getpeercert(binary_form=True)
    return reader, writer, certificate


async def answers(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> bool:
    writer.write(b"here\n")
    return await reader.readline() == b"here\n"


async def test_a_new_certificate_is_used_by_new_connections_and_old_ones_go_on(authority: TestAuthority) -> None:
    tls = ServerTls(*authority.issue("cloud"))
    async with echo_server(tls) as port:
        reader, writer, first = await connect(port, authority)
        authority.issue("cloud")
        tls.reload_if_changed()
        other_reader, other, second = await connect(port, authority)
        assert second != first
        assert await answers(reader, writer)
        assert await answers(other_reader, other)
        writer.close()
        other.close()


async def test_the_files_are_watched(authority: TestAuthority) -> None:
    tls = ServerTls(*authority.issue("cloud"))
    async with echo_server(tls) as port:
        watching = asyncio.create_task(tls.watch(period=0.01))
        _, writer, first = await connect(port, authority)
        writer.close()
        authority.issue("cloud")
        async with patience(30):
            while (found := await connect(port, authority))[2] == first:
                found[1].close()
        found[1].close()
        watching.cancel()


async def test_no_handshake_fails_while_the_files_are_read_again(authority: TestAuthority) -> None:
    tls = ServerTls(*authority.issue("cloud"))
    async with echo_server(tls) as port:
        watching = asyncio.create_task(asyncio.to_thread(read_again, tls, 300))
        while not watching.done():
            (await connect(port, authority))[1].close()
        await watching


def read_again(tls: ServerTls, times: int) -> None:
    for number in range(times):
        tls._loaded = ((number, 0, 0),)  # not the stamp of any file
        tls.reload_if_changed()


async def test_tls_1_1_is_refused(authority: TestAuthority) -> None:
    async with echo_server(ServerTls(*authority.issue("cloud"))) as port:
        with pytest.raises((ssl.SSLError, ConnectionError)), pytest.warns(DeprecationWarning):
            await connect(port, authority, ssl.TLSVersion.TLSv1_1)


async def test_unusable_new_files_are_reported_once_and_the_certificate_stays(
    authority: TestAuthority, caplog: pytest.LogCaptureFixture
) -> None:
    certificate, key = authority.issue("cloud")
    tls = ServerTls(certificate, key)
    caplog.set_level(logging.INFO)
    async with echo_server(tls) as port:
        key.write_bytes(authority.issue("other")[1].read_bytes())
        tls.reload_if_changed()
        assert not caplog.records  # the certificate may follow at once
        for _ in range(3):
            tls.reload_if_changed()
        assert [record.levelname for record in caplog.records] == ["ERROR"]
        _, writer, _ = await connect(port, authority)
        writer.close()
        certificate.unlink()
        for _ in range(3):
            tls.reload_if_changed()
        authority.issue("cloud")
        tls.reload_if_changed()
        assert caplog.records[-1].levelname == "INFO"


@pytest.mark.parametrize("fault", ["missing", "not PEM", "of another", "encrypted"])
def test_unusable_files_are_an_error_at_the_start(authority: TestAuthority, fault: str) -> None:
    certificate, key = authority.issue("cloud")
    match fault:
        case "missing":
            key.unlink()
        case "not PEM":
            certificate.write_text("certificate")
        case "of another":
            key = authority.issue("other")[1]
        case _:
            secret = read_key(key.read_bytes())
            key.write_bytes(secret.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, BestAvailableEncryption(b"hidden")))
    with pytest.raises(InvalidInput, match="cannot use the certificate"):
        ServerTls(certificate, key)


@pytest.mark.parametrize(("host", "warned"), [("127.0.0.1", False), ("127.0.0.5", False), ("0.0.0.0", True)])
def test_a_warning_tells_that_other_hosts_connect_without_tls(
    host: str, warned: bool, caplog: pytest.LogCaptureFixture
) -> None:
    with socket.create_server((host, 0)) as listener:
        warn_if_open_to_others([listener])
    assert ("unencrypted" in caplog.text) == warned
