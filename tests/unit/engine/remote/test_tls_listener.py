"""The TLS listener over real TLS: admitted and refused clients."""

import asyncio
import contextlib
import datetime
import ssl
from collections.abc import AsyncIterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from engine.protocols.address import TlsAddress
from engine.protocols.sockets import dial
from engine.protocols.tls_identity import TlsIdentity, stranger_context
from engine.remote import machines
from engine.remote.authority import Authority
from engine.remote.machines import MutualTlsListener
from ppaas.errors import InvalidInput, Unavailable
from tests.support.engine.tls_cloud import joined
from tests.support.waiting import patience

ANYWHERE = TlsAddress("127.0.0.1", 0)


@pytest.fixture(scope="module")
def authority(tmp_path_factory: pytest.TempPathFactory) -> Authority:
    return Authority(tmp_path_factory.mktemp("cloud") / "machines")


@pytest.fixture
async def listener(authority: Authority) -> AsyncIterator[MutualTlsListener]:
    def answering(what: str):  # type: ignore[no-untyped-def]
        async def serve(_: asyncio.StreamReader, writer: asyncio.StreamWriter, machine: str = "nobody") -> None:
            writer.write(f"{what} {machine}\n".encode())
            await writer.drain()

        return serve

    opened = MutualTlsListener(
        ANYWHERE, authority,
        control=answering("control"), robot=answering("robot"), settings=answering("terms"),
        standby=answering("standby"), endpoint=answering("endpoint"), join=answering("join"),
    )  # fmt: skip
    await opened.start()
    yield opened
    await opened.close()


async def answer(listener: MutualTlsListener, context: ssl.SSLContext) -> str:
    """Return the line that the listener answers; empty if it closes the connection."""
    reader, writer = await dial(listener.address, context)
    try:
        async with patience(5.0):
            return (await reader.readline()).decode().strip()
    except OSError:  # TLS 1.3 reports a refused certificate after the client has finished its handshake
        return ""
    finally:
        writer.transport.abort()


async def test_a_machine_is_identified_by_its_certificate_and_dispatched_by_purpose(
    listener: MutualTlsListener, authority: Authority, tmp_path: Path
) -> None:
    identity = joined(authority, tmp_path / "m2", "m2")
    assert await answer(listener, identity.client_context("control")) == "control m2"
    assert await answer(listener, identity.client_context("robot")) == "robot m2"


async def test_a_client_without_a_certificate_can_only_request_to_join(
    listener: MutualTlsListener, authority: Authority
) -> None:
    stranger = stranger_context()
    assert await answer(listener, stranger) == "join nobody"
    for purposes in (["control"], ["robot"], ["other"], []):
        stranger.set_alpn_protocols(purposes or ["http/1.1"])
        with contextlib.suppress(Unavailable):  # refused during the handshake
            assert await answer(listener, stranger) == ""


async def test_clients_that_join_are_limited(authority: Authority, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machines, "MAX_JOINING", 2)
    go = asyncio.Event()

    async def join(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await go.wait()
        writer.write(b"join\n")
        await writer.drain()

    async def machine(*_: object) -> None:
        raise AssertionError("it has no certificate")

    opened = MutualTlsListener(
        ANYWHERE,
        authority,
        control=machine,
        robot=machine,
        settings=machine,
        standby=machine,
        endpoint=machine,
        join=join,
    )
    await opened.start()
    try:
        waiting = [asyncio.create_task(answer(opened, stranger_context())) for _ in range(2)]
        while opened._joining < 2:
            await asyncio.sleep(0.01)
        assert await answer(opened, stranger_context()) == ""
        go.set()
        assert await asyncio.gather(*waiting) == ["join", "join"]
        assert await answer(opened, stranger_context()) == "join"
    finally:
        await opened.close()


async def test_a_certificate_of_another_authority_is_refused(
    listener: MutualTlsListener, authority: Authority, tmp_path: Path
) -> None:
    theirs = joined(Authority(tmp_path / "other"), tmp_path / "m", "m2")
    ours = TlsIdentity(
        theirs.key, theirs.certificate, authority.identity.authority
    )  # it trusts our cloud, but not vice versa
    assert await answer(listener, ours.client_context("control")) == ""
    with pytest.raises(Unavailable, match="certificate"):  # a machine does not talk to another cloud
        await dial(listener.address, theirs.client_context("control"))


async def test_only_the_latest_certificate_of_a_machine_is_valid(
    listener: MutualTlsListener, authority: Authority, tmp_path: Path
) -> None:
    first = joined(authority, tmp_path / "first", "m3")
    second = joined(authority, tmp_path / "second", "m3")
    assert await answer(listener, first.client_context("control")) == ""
    assert await answer(listener, second.client_context("control")) == "control m3"


async def test_a_machine_cannot_impersonate_the_cloud(authority: Authority, tmp_path: Path) -> None:
    posing = joined(authority, tmp_path / "posing", "cloud.ppaas")
    server = await asyncio.start_server(lambda *_: None, "127.0.0.1", 0, ssl=posing.server_context())
    machine = joined(authority, tmp_path / "m4", "m4")
    address = ANYWHERE._replace(port=server.sockets[0].getsockname()[1])
    with pytest.raises(Unavailable, match="certificate"):
        await dial(address, machine.client_context("control"))
    server.close()


async def test_hosts_trust_each_other_although_the_clock_of_one_is_hours_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Ahead(datetime.datetime):
        """Clock of a cloud, seen by a host that is three hours behind."""

        @classmethod
        def now(cls, tz: datetime.tzinfo | None = None) -> datetime.datetime:
            return datetime.datetime.now(tz) + datetime.timedelta(hours=3)

    monkeypatch.setattr("engine.remote.authority.datetime", SimpleNamespace(datetime=Ahead, UTC=datetime.UTC))
    authority = Authority(tmp_path / "cloud")
    machine = joined(authority, tmp_path / "m5", "m5")
    came = asyncio.Event()
    context = authority.identity.server_context()
    server = await asyncio.start_server(lambda *_: came.set(), "127.0.0.1", 0, ssl=context)
    address = ANYWHERE._replace(port=server.sockets[0].getsockname()[1])
    _, writer = await dial(address, machine.client_context("control"))
    async with patience(5.0):
        await came.wait()
    writer.transport.abort()
    server.close()


async def test_a_connection_without_tls_is_closed(listener: MutualTlsListener) -> None:
    reader, writer = await asyncio.open_connection(listener.address.host, listener.address.port)
    writer.write(b"GET / HTTP/1.1\r\n\r\n" * 4)
    async with patience(5.0):
        while await reader.read(4096):
            pass
    writer.close()


async def test_a_port_in_use_is_an_error(listener: MutualTlsListener, authority: Authority) -> None:
    async def nobody(*_: object) -> None: ...

    second = MutualTlsListener(
        listener.address,
        authority,
        control=nobody,
        robot=nobody,
        settings=nobody,
        standby=nobody,
        endpoint=nobody,
        join=nobody,
    )
    with pytest.raises(Unavailable, match="cannot listen"):
        await second.start()


async def test_links_between_machines_need_certificates(listener: MutualTlsListener) -> None:
    with pytest.raises(InvalidInput, match="ticket"):
        await dial(listener.address)


async def test_certificates_survive_a_restart_of_the_cloud(authority: Authority, tmp_path: Path) -> None:
    joined(authority, tmp_path / "m5", "m5")
    again = Authority(authority.identity.key.parent)
    assert again.pem == authority.pem
    assert again.has_issued("m5") and not again.has_issued("m6")


@pytest.mark.parametrize("name", ["", ".", "..", "a/b", "../cloud", "x" * 65, "ä", "a b", "-x"])
def test_an_invalid_name_is_refused(authority: Authority, name: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="not a valid name"):
        authority.issue(name, b"")


@pytest.mark.parametrize("request_", [b"", b"rubbish", b"-----BEGIN CERTIFICATE REQUEST-----\nAAAA\n"])
def test_an_invalid_certificate_request_is_refused(authority: Authority, request_: bytes) -> None:
    with pytest.raises(InvalidInput, match="request"):
        authority.issue("m7", request_)
    assert not authority.has_issued("m7")


def test_an_unreadable_authority_is_an_error(tmp_path: Path) -> None:
    folder = tmp_path / "machines"
    Authority(folder)
    (folder / "authority.key").write_text("rubbish")
    with pytest.raises(InvalidInput, match="cannot be read"):
        Authority(folder)


def test_keys_are_readable_by_their_owner_only(authority: Authority) -> None:
    for key in authority.identity.key.parent.glob("*.key"):
        assert key.stat().st_mode & 0o077 == 0
