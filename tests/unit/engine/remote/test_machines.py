"""Machines of other hosts join a cloud, get its settings, and are refused."""

import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

import msgspec
import pytest

from engine.links.control_server import ControlServer
from engine.links.robot_link_server import LinkServer
from engine.protocols import control_link
from engine.protocols.address import TlsAddress
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import dial
from engine.protocols.tls_identity import stranger_context
from engine.protocols.versions import Protocols
from engine.remote.agent import MachineOptions, SocketFolders, config_of, stay
from engine.remote.cluster_settings import ContainerSettings
from engine.remote.machines import RemoteMachines, make_ticket
from engine.remote.masters import Masters
from engine.remote.membership import Membership, join, membership_in
from ppaas.errors import Conflict, InvalidInput, NotFound, NotPermitted, Unavailable
from storage.urls.opening import open_map_store, open_store
from tests.support.engine.engine_links import receive, register
from tests.support.waiting import patience, until
from tests.unit.engine.links.test_control_server import Events

ANYWHERE = TlsAddress("127.0.0.1", 0)
VALID = 60.0


class Cloud:
    """The part of a cloud that machines of other hosts connect to."""

    def __init__(self, folder: Path, sockets: Path) -> None:
        self.folder = folder / "machines"
        self.events = Events()
        self.stores = f"sqlite:///{folder / 'store.sqlite'}", f"file:///{folder / 'maps'}"
        open_store(self.stores[0]).close()
        open_map_store(self.stores[1])
        self.far = RemoteMachines(
            self.folder, ANYWHERE, cloud="the cloud", store=self.stores[0], map_store=self.stores[1], own="local",
            runs=ContainerSettings("docker", "an-image", ("ppaas.planners:mine",)),
        )  # fmt: skip
        self.control = ControlServer(sockets / "control.sock", "secret", self.events)

    async def start(self) -> None:
        async def welcome(*_: object) -> None: ...

        await self.far.start(self.control, LinkServer(Path("unused"), welcome, lambda _: None), welcome)

    def ticket(self, machine: str | None = None) -> str:
        return str(make_ticket(self.folder, valid=VALID, machine=machine))


@pytest.fixture
async def cloud(tmp_path: Path) -> AsyncIterator[Cloud]:
    opened = Cloud(tmp_path, tmp_path)
    await opened.start()
    yield opened
    await opened.far.close()


async def connected(membership: Membership) -> FrameStream[control_link.ToAgent]:
    context = membership.identity.client_context("control")
    return FrameStream(*await dial(membership.cloud, context), control_link.ToAgent)


async def test_machine_joins_with_a_ticket_and_registers_by_certificate(cloud: Cloud, tmp_path: Path) -> None:
    membership = await join(tmp_path / "m2", cloud.ticket(), "m2")
    stream = await connected(membership)
    stream.write(register("m2", secret=""))
    await until(lambda: cloud.events.calls)
    assert cloud.events.calls == [("registered", "m2")]
    await stream.close()


async def test_each_heartbeat_is_acknowledged(cloud: Cloud, tmp_path: Path) -> None:
    stream = await connected(await join(tmp_path / "m2", cloud.ticket(), "m2"))
    stream.write(register("m2", secret=""))
    for _ in range(3):
        stream.write(control_link.AgentBeat())
        assert await receive(stream) == control_link.BeatAcknowledged()
    await stream.close()


async def test_the_agent_is_configured_from_the_cluster_settings(cloud: Cloud, tmp_path: Path) -> None:
    membership = await join(tmp_path / "m2", cloud.ticket(), "m2")
    masters = Masters(membership)
    settings = await masters.settings()
    config = config_of(
        membership, MachineOptions(2, {"gpu": "no"}), settings, SocketFolders(tmp_path / "run", None), masters
    )
    assert (config.store, config.map_store) == cloud.stores
    assert (config.identity, config.cloud) == (str(tmp_path / "m2"), "the cloud")
    assert config.peering is not None and config.peering.connect == (f"tls/127.0.0.1:{settings.fabric_port}",)
    assert config.peering.credentials == cloud.far.peering.credentials
    assert (config.cores, config.labels) == (2, {"gpu": "no"})
    assert (config.runtime, config.image, config.allowed) == ("docker", "an-image", ("ppaas.planners:mine",))


async def test_missing_stores_are_not_created(cloud: Cloud, tmp_path: Path) -> None:
    membership = await join(tmp_path / "m2", cloud.ticket(), "m2")
    settings = await membership.settings()
    (tmp_path / "store.sqlite").unlink()
    with pytest.raises(NotFound, match="store"):
        config_of(membership, MachineOptions(), settings, SocketFolders(tmp_path / "run", None), Masters(membership))


async def test_machine_exits_if_it_speaks_no_protocol_of_the_cloud(
    cloud: Cloud, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The machine exits, to be started again with the new release; a retry would run the old one for ever."""
    membership = await join(tmp_path / "m2", cloud.ticket(), "m2")
    # A machine keeps its temporary files in its own folder; later tests must not.
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    other = msgspec.structs.replace(cloud.far._settings, protocols=Protocols(8, 9))
    monkeypatch.setattr(cloud.far, "_settings", other)
    with pytest.raises(Conflict, match=r"the cloud runs release .* with protocols 8 to 9.*upgrade this process first"):
        await stay(membership, MachineOptions())


async def test_joining_again_with_the_same_ticket_works_offline(cloud: Cloud, tmp_path: Path) -> None:
    ticket = cloud.ticket()
    first = await join(tmp_path / "m2", ticket, "m2")
    await cloud.far.close()
    assert await join(tmp_path / "m2", ticket, "m2") == first == membership_in(tmp_path / "m2")


async def test_machines_stay_known_after_a_restart_of_the_cloud(cloud: Cloud, tmp_path: Path) -> None:
    membership = await join(tmp_path / "m2", cloud.ticket(), "m2")
    await cloud.far.close()
    again = Cloud(tmp_path, tmp_path)
    await again.start()
    moved = Membership(membership.folder, "m2", TlsAddress("127.0.0.1", int(_port(again))))
    assert (await moved.settings()).cloud == "the cloud"
    await again.far.close()


def _port(cloud: Cloud) -> str:
    return (cloud.folder / "address").read_text().rpartition(":")[2]


async def test_reusing_a_machine_name_needs_a_ticket_for_it(cloud: Cloud, tmp_path: Path) -> None:
    first = await join(tmp_path / "m2", cloud.ticket(), "m2")
    with pytest.raises(Conflict, match="--name m2"):
        await join(tmp_path / "other", cloud.ticket(), "m2")
    await join(tmp_path / "other", cloud.ticket("m2"), "m2")
    with pytest.raises(Unavailable, match="closed the connection"):  # the first one's certificate was revoked
        await first.settings()


@pytest.mark.parametrize("name", ["local", "a/b", ""])
async def test_a_taken_or_invalid_name_is_refused(cloud: Cloud, tmp_path: Path, name: str) -> None:
    with pytest.raises((Conflict, InvalidInput), match=r"named 'local'|not a valid name"):
        await join(tmp_path / "m2", cloud.ticket(), name)
    with pytest.raises(NotFound):
        membership_in(tmp_path / "m2")


async def test_a_used_ticket_is_refused(cloud: Cloud, tmp_path: Path) -> None:
    ticket = cloud.ticket()
    await join(tmp_path / "m2", ticket, "m2")
    with pytest.raises(NotPermitted, match="was used"):
        await join(tmp_path / "m3", ticket, "m3")


async def test_a_ticket_is_not_sent_to_another_cloud(cloud: Cloud, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    other = Cloud(tmp_path / "other", tmp_path)
    await other.start()
    ours = make_ticket(cloud.folder, valid=VALID)
    astray = type(ours)(ours.host, int(_port(other)), ours.cloud, ours.secret)
    with pytest.raises(NotPermitted, match="not the cloud"):
        await join(tmp_path / "m2", str(astray), "m2")
    await join(tmp_path / "m2", str(ours), "m2")  # it is still valid
    await other.far.close()


async def test_an_unreachable_cloud_is_an_error(cloud: Cloud, tmp_path: Path) -> None:
    ticket = cloud.ticket()
    await cloud.far.close()
    with pytest.raises(Unavailable, match="no answer"):
        await join(tmp_path / "m2", ticket, "m2")


async def test_no_ticket_is_made_without_a_cloud_that_accepts_machines(cloud: Cloud, tmp_path: Path) -> None:
    with pytest.raises(Unavailable, match="--listen-machines"):
        make_ticket(tmp_path / "nowhere", valid=VALID)
    await cloud.far.close()
    with pytest.raises(Unavailable, match="--listen-machines"):
        cloud.ticket()


@pytest.mark.parametrize("urls", [("memory:", "file:///maps"), ("sqlite:///s", "memory:")])
def test_stores_in_memory_are_refused(tmp_path: Path, urls: tuple[str, str]) -> None:
    with pytest.raises(InvalidInput, match="cassandra:"):
        RemoteMachines(tmp_path, ANYWHERE, cloud="c", store=urls[0], map_store=urls[1], own="local")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("data", [(100).to_bytes(4, "big") + b"\xc1" * 100, (1 << 20).to_bytes(4, "big")])
async def test_an_invalid_or_oversized_request_to_join_closes_the_connection(
    cloud: Cloud, caplog: pytest.LogCaptureFixture, data: bytes
) -> None:
    ticket = make_ticket(cloud.folder, valid=VALID)
    reader, writer = await dial(ticket.address, stranger_context())
    writer.write(data)
    async with patience(10.0):
        assert await reader.read() == b""
    assert "sent no valid request to join" in caplog.text
    writer.transport.abort()
