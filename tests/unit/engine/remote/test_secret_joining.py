"""Machines and standbys join with a secret over real TLS, and are refused."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from engine.links.control_server import ControlServer
from engine.links.robot_link_server import LinkServer
from engine.protocols.address import TlsAddress, parse_address
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import dial
from engine.protocols.tls_identity import stranger_context
from engine.remote.authority import STANDBY, Authority, new_key, request_pem
from engine.remote.join_secrets import MOST_WRONG, SHORTEST, JoinSecrets
from engine.remote.joining import JoinBySecret, JoinChallenge, JoinedBySecret, JoinProof, NotJoined
from engine.remote.machines import RemoteMachines, make_ticket
from engine.remote.membership import Membership, join, join_by_secret, membership_in
from engine.remote.secret_joining import NONCE, FromCloud, request_by_secret
from ppaas.errors import Conflict, InvalidInput, NotFound, NotPermitted, TooManyAttempts, Unavailable
from tests.support.waiting import patience, until
from tests.unit.engine.links.test_control_server import Events

ONE, OTHER, STANDBYS = "1" * SHORTEST, "2" * SHORTEST, "3" * SHORTEST
ANYWHERE = TlsAddress("127.0.0.1", 0)


class Cloud:
    """The part of a cloud at which machines join."""

    def __init__(self, folder: Path) -> None:
        self.machines, self.standbys = folder / "machines.secret", folder / "standbys.secret"
        self.machines.write_text(ONE)
        self.standbys.write_text(STANDBYS)
        self.folder = folder / "cloud" / "machines"
        self.folder.parent.mkdir()
        self.far = RemoteMachines(
            self.folder, ANYWHERE, cloud="c", store="sqlite:///s", map_store="file:///m", own="local",
            join_secrets=JoinSecrets(self.machines, self.standbys),
        )  # fmt: skip
        self.control = ControlServer(folder / "control.sock", "secret", Events())
        self.address = ANYWHERE

    async def start(self) -> None:
        async def welcome(*_: object) -> None: ...

        await self.far.start(self.control, LinkServer(Path("unused"), welcome, lambda _: None), welcome)
        address = parse_address((self.folder / "address").read_text())
        assert isinstance(address, TlsAddress)
        self.address = address

    async def join(self, folder: Path, secrets: str, name: str = "m2") -> Membership:
        """Join with the secrets of a file."""
        file = folder.with_suffix(".secret")
        file.write_text(secrets)
        return await join_by_secret(folder, file, name, (self.address,))


@pytest.fixture
async def cloud(tmp_path: Path) -> AsyncIterator[Cloud]:
    opened = Cloud(tmp_path)
    await opened.start()
    yield opened
    await opened.far.close()


async def test_a_machine_joins_with_a_secret_and_is_known_by_its_certificate(
    cloud: Cloud, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    membership = await cloud.join(tmp_path / "m2", ONE)
    assert (await membership.settings()).cloud == "c"
    assert "m2 at 127.0.0.1 joined with a secret" in caplog.text
    assert ONE not in caplog.text
    assert membership == membership_in(tmp_path / "m2")


async def test_a_machine_that_has_joined_starts_without_its_cloud(cloud: Cloud, tmp_path: Path) -> None:
    membership = await cloud.join(tmp_path / "m2", ONE)
    await cloud.far.close()
    assert await cloud.join(tmp_path / "m2", ONE) == membership


async def test_a_wrong_secret_is_refused_and_nothing_is_stored(
    cloud: Cloud, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(NotPermitted, match="unknown or was replaced"):
        await cloud.join(tmp_path / "m2", OTHER)
    with pytest.raises(NotFound):
        membership_in(tmp_path / "m2")
    assert not Authority(cloud.folder).has_issued("m2")
    assert "request of 'm2' at 127.0.0.1 to join with a secret was refused" in caplog.text


async def test_a_rotated_secret_lets_new_machines_in_and_keeps_the_old_ones(cloud: Cloud, tmp_path: Path) -> None:
    first = await cloud.join(tmp_path / "m2", ONE)
    cloud.machines.write_text(f"{OTHER}\n{ONE}")
    await cloud.join(tmp_path / "m3", ONE, "m3")
    await cloud.join(tmp_path / "m4", OTHER, "m4")
    cloud.machines.write_text(OTHER)
    with pytest.raises(NotPermitted, match="was replaced"):
        await cloud.join(tmp_path / "m5", ONE, "m5")
    await cloud.join(tmp_path / "m5", f"{ONE}\n{OTHER}", "m5")
    assert (await first.settings()).cloud == "c"


async def test_an_expired_secret_is_refused(cloud: Cloud, tmp_path: Path) -> None:
    cloud.machines.write_text(f"{ONE} until=2001-01-01T00:00:00Z")
    with pytest.raises(NotPermitted, match="has expired"):
        await cloud.join(tmp_path / "m2", ONE)


async def test_a_machine_that_lost_its_folder_gets_its_name_again(cloud: Cloud, tmp_path: Path) -> None:
    before = await cloud.join(tmp_path / "before", ONE)
    after = await cloud.join(tmp_path / "after", ONE)
    assert (await after.settings()).cloud == "c"
    with pytest.raises(Unavailable, match="closed the connection"):
        await before.settings()


async def test_the_name_of_a_connected_machine_is_refused(
    cloud: Cloud, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    await cloud.join(tmp_path / "before", ONE)
    monkeypatch.setattr(cloud.control, "is_connected", "m2".__eq__)
    with pytest.raises(Conflict, match="'m2' is connected"):
        await cloud.join(tmp_path / "after", ONE)


async def test_the_name_of_a_machine_with_a_ticket_is_refused(cloud: Cloud, tmp_path: Path) -> None:
    first = await join(tmp_path / "first", str(make_ticket(cloud.folder, valid=60.0)), "m2")
    for name in ("m2", "local"):
        with pytest.raises(Conflict, match="--name"):
            await cloud.join(tmp_path / "second", ONE, name)
    assert (await first.settings()).cloud == "c"


@pytest.mark.parametrize("name", ["", "a/b", "x" * 65])
async def test_an_invalid_name_is_refused(cloud: Cloud, tmp_path: Path, name: str) -> None:
    with pytest.raises(InvalidInput, match="not a valid name"):
        await request_by_secret(cloud.address, ONE, name, request_pem(new_key(), "m2"))


async def test_standbys_have_their_own_secret(cloud: Cloud, tmp_path: Path) -> None:
    with pytest.raises(NotPermitted, match="for machines only"):
        await cloud.join(tmp_path / "b", ONE, f"b{STANDBY}")
    with pytest.raises(NotPermitted, match="for standbys only"):
        await cloud.join(tmp_path / "m2", STANDBYS)
    joined = await cloud.join(tmp_path / "b", STANDBYS, f"b{STANDBY}")
    assert joined.machine == f"b{STANDBY}"


async def test_many_wrong_secrets_of_an_address_are_not_looked_at(cloud: Cloud) -> None:
    request = request_pem(new_key(), "m2")
    for _ in range(MOST_WRONG):
        with pytest.raises(NotPermitted):
            await request_by_secret(cloud.address, OTHER, "m2", request)
    with pytest.raises(TooManyAttempts, match="too many wrong join secrets"):
        await request_by_secret(cloud.address, ONE, "m2", request)


async def posing(server: Authority, answer: FromCloud) -> tuple[TlsAddress, asyncio.Server]:
    """Listen as a server that answers a request to join, and a proof, without any secret."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        stream: FrameStream[JoinBySecret | JoinProof] = FrameStream(reader, writer, JoinBySecret | JoinProof)
        await stream.receive()
        await stream.send(answer)
        if isinstance(answer, JoinChallenge):
            await stream.receive()
            await stream.send(JoinedBySecret(b"certificate", b"authority", b"proof"))
        await stream.close()

    listening = await asyncio.start_server(serve, "127.0.0.1", 0, ssl=server.identity.server_context())
    return ANYWHERE._replace(port=listening.sockets[0].getsockname()[1]), listening


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (JoinChallenge(b"c" * NONCE), "has not proven"),
        (JoinedBySecret(b"certificate", b"authority", b"proof"), "does not answer as a cloud does"),
    ],
)
async def test_a_machine_takes_no_certificate_of_a_server_without_the_secret(
    tmp_path: Path, answer: FromCloud, reason: str
) -> None:
    address, listening = await posing(Authority(tmp_path / "posing"), answer)
    (tmp_path / "secret").write_text(ONE)
    with pytest.raises(NotPermitted, match=reason):
        await join_by_secret(tmp_path / "m2", tmp_path / "secret", "m2", (address,))
    assert not (tmp_path / "m2").exists()
    listening.close()


async def test_a_server_in_between_gains_nothing(cloud: Cloud, tmp_path: Path) -> None:
    """It forwards all messages between machine and cloud, and shows its own certificate."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, back = await dial(cloud.address, stranger_context())
        await asyncio.gather(pump(reader, back), pump(there, writer))

    listening = await asyncio.start_server(
        serve, "127.0.0.1", 0, ssl=Authority(tmp_path / "between").identity.server_context()
    )
    address = ANYWHERE._replace(port=listening.sockets[0].getsockname()[1])
    with pytest.raises(NotPermitted, match="unknown or was replaced"):
        await request_by_secret(address, ONE, "m2", request_pem(new_key(), "m2"))
    assert not Authority(cloud.folder).has_issued("m2")
    listening.close()


async def pump(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    while data := await reader.read(4096):
        writer.write(data)
    writer.close()


async def talk(cloud: Cloud, *messages: object) -> NotJoined | JoinChallenge | JoinedBySecret | None:
    """Return what the cloud answers last to messages."""
    stream: FrameStream[FromCloud] = FrameStream(*await dial(cloud.address, stranger_context()), FromCloud)
    answer = None
    for message in messages:
        await stream.send(message)
        async with patience(10.0):
            answer = await stream.receive()
    await stream.close()
    return answer


async def test_a_proof_is_not_valid_again(cloud: Cloud) -> None:
    asked = JoinBySecret("m2", request_pem(new_key(), "m2"), b"n" * NONCE)
    refused = await talk(cloud, asked, JoinProof(b"p" * 32))
    assert isinstance(refused, NotJoined) and "unknown" in refused.refusal.text
    first, second = await talk(cloud, asked), await talk(cloud, asked)
    assert isinstance(first, JoinChallenge) and first != second, "so a recorded proof does not fit another challenge"


@pytest.mark.parametrize(
    ("messages", "reason"),
    [
        ([JoinProof(b"p")], "proof before a request"),
        ([JoinBySecret("m2", b"", b"short")], "has 5 bytes"),
        ([JoinBySecret("m2", b"", b"n" * NONCE)] * 2, "not answered with a proof"),
    ],
)
async def test_a_client_that_violates_the_protocol_is_disconnected(
    cloud: Cloud, caplog: pytest.LogCaptureFixture, messages: list[object], reason: str
) -> None:
    assert await talk(cloud, *messages) is None
    await until(lambda: reason in caplog.text)


async def test_the_first_master_that_answers_is_joined(cloud: Cloud, tmp_path: Path) -> None:
    (tmp_path / "secret").write_text(ONE)
    away = TlsAddress("127.0.0.1", 1)
    joined = await join_by_secret(tmp_path / "m2", tmp_path / "secret", "m2", (away, cloud.address))
    assert joined.cloud == cloud.address
    with pytest.raises(Unavailable, match=r"no answer at tls://127\.0\.0\.1:1"):
        await join_by_secret(tmp_path / "m3", tmp_path / "secret", "m3", (away,))
