"""Standbys of a leader over real TLS: they copy its files, prove themselves to machines, and are refused."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from engine.links.control_server import ControlServer
from engine.links.robot_link_server import LinkServer
from engine.protocols import control_link
from engine.protocols.address import TlsAddress, parse_address
from engine.protocols.framing import FrameStream
from engine.protocols.sockets import dial
from engine.protocols.versions import Protocols
from engine.remote.authority import STANDBY, Authority
from engine.remote.cluster_settings import ClusterSettings
from engine.remote.machines import RemoteMachines, make_ticket
from engine.remote.masters import FILE, MOST, KnownMasters, Masters
from engine.remote.membership import Membership, join
from engine.remote.replica import LAST, MACHINES, in_order, keep_only, read_files, write_file
from engine.remote.standbys import StandbyHello, StandbyLink, StandbyRefused, ToStandby, membership_of
from ppaas import __version__
from ppaas.errors import InvalidInput, MalformedMessage, NotPermitted, Unavailable
from tests.support.engine.engine_links import receive, register
from tests.support.waiting import until
from tests.unit.engine.links.test_control_server import Deputy, Events

LOOPBACK = "127.0.0.1"
ELSEWHERE = TlsAddress(LOOPBACK, 8600)


class Leader:
    """The part of a cloud process that machines and standbys connect to."""

    def __init__(self, data: Path, epoch: int) -> None:
        self.data = data
        data.mkdir(exist_ok=True)
        (data.parent / "store.sqlite").touch()
        store, maps = f"sqlite:///{data.parent / 'store.sqlite'}", f"file:///{data.parent}"
        self.far = RemoteMachines(
            data / MACHINES, TlsAddress(LOOPBACK, 0), cloud=data.name, store=store, map_store=maps, own="local"
        )
        self.events, self.mandate = Events(), Deputy(epoch)
        self.control = ControlServer(data / "control.sock", "secret", self.events)
        self.control.mandate = self.mandate
        self.address = ELSEWHERE

    async def start(self) -> None:
        async def welcome(*_: object) -> None: ...

        await self.far.start(self.control, LinkServer(Path("unused"), welcome, lambda _: None), welcome)
        address = parse_address((self.data / MACHINES / "address").read_text())
        assert isinstance(address, TlsAddress)
        self.address = address

    def ticket(self, name: str | None = None) -> str:
        return str(make_ticket(self.data / MACHINES, valid=60.0, machine=name))


@asynccontextmanager
async def leading(data: Path, epoch: int = 1) -> AsyncIterator[Leader]:
    leader = Leader(data, epoch)
    await leader.start()
    try:
        yield leader
    finally:
        await leader.far.close()


@pytest.fixture
async def leader(tmp_path: Path) -> AsyncIterator[Leader]:
    async with leading(tmp_path / "a") as opened:
        yield opened


@asynccontextmanager
async def copying(leader: Leader, data: Path) -> AsyncIterator[Membership]:
    """Stand by for a leader with a ticket, until the block ends."""
    membership = await membership_of(data, leader.ticket(f"b{STANDBY}"), "unused")
    assert membership is not None
    link = StandbyLink(data, membership, ELSEWHERE)
    task = asyncio.create_task(link.run())
    try:
        await asyncio.wait_for(link.complete.wait(), 10.0)
        yield membership
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def test_a_standby_has_the_files_of_its_leader_as_they_change(leader: Leader, tmp_path: Path) -> None:
    standby = tmp_path / "b"
    async with copying(leader, standby):
        (leader.data / "machine-settings.json").write_text("{}")
        await join(tmp_path / "m2", leader.ticket(), "m2")
        await until(lambda: read_files(standby) == read_files(leader.data))
        assert f"{MACHINES}/issued/m2.pem" in read_files(standby)
        assert not any("tickets" in name for name in read_files(standby)), "a used ticket is used everywhere"
    assert Authority(standby / MACHINES).fingerprint == Authority(leader.data / MACHINES).fingerprint
    assert all(path.stat().st_mode & 0o077 == 0 for path in (standby / MACHINES).rglob("*"))


async def test_a_certificate_that_was_withdrawn_while_a_standby_was_away_is_withdrawn_there(
    leader: Leader, tmp_path: Path
) -> None:
    await join(tmp_path / "m2", leader.ticket(), "m2")
    async with copying(leader, tmp_path / "b"):
        assert f"{MACHINES}/issued/m2.pem" in read_files(tmp_path / "b")
    (leader.data / MACHINES / "issued" / "m2.pem").unlink()
    async with copying(leader, tmp_path / "b"):
        assert f"{MACHINES}/issued/m2.pem" not in read_files(tmp_path / "b")
        assert read_files(tmp_path / "b").keys() == read_files(leader.data).keys()


async def test_machines_are_told_of_a_standby_and_follow_it(leader: Leader, tmp_path: Path) -> None:
    membership = await join(tmp_path / "m2", leader.ticket(), "m2")
    masters = Masters(membership)
    assert (await masters.settings()).masters == ()
    context = membership.identity.client_context("control")
    stream: FrameStream[control_link.ToAgent] = FrameStream(*await dial(leader.address, context), control_link.ToAgent)
    stream.write(register("m2", secret=""))
    await until(lambda: leader.events.calls)
    async with copying(leader, tmp_path / "b"):
        changed = await receive(stream)
        assert changed == control_link.MastersChanged((str(ELSEWHERE),))
        routers = masters.note(changed.masters)
        assert routers[1:] == (f"tls/{LOOPBACK}:{ELSEWHERE.port + 1}",)
        await until(lambda: f"{MACHINES}/issued/m2.pem" in read_files(tmp_path / "b"))
    await stream.close()
    await leader.far.close()
    async with leading(tmp_path / "b", epoch=2) as heir:
        masters.note((str(heir.address),))
        assert (await masters.settings()).cloud == "b", "by the certificate that the first leader issued"
        assert (masters.epoch, masters.current) == (2, str(heir.address))
        assert {heir.address, ELSEWHERE} == set(KnownMasters(membership.folder).addresses), "also after a restart"


async def test_a_machine_refuses_settings_of_an_earlier_epoch(leader: Leader, tmp_path: Path) -> None:
    masters = Masters(await join(tmp_path / "m2", leader.ticket(), "m2"))
    masters.epoch = 2
    with pytest.raises(Unavailable, match="epoch 1, and another one has led since, in epoch 2"):
        await masters.settings()


async def test_a_master_that_does_not_lead_sends_no_settings_and_no_files(leader: Leader, tmp_path: Path) -> None:
    membership = await join(tmp_path / "m2", leader.ticket(), "m2")
    invited = await membership_of(tmp_path / "b", leader.ticket(f"b{STANDBY}"), "unused")
    assert invited is not None
    leader.mandate.holds = False
    with pytest.raises(Unavailable, match="closed the connection"):
        await Masters(membership).settings()
    link = StandbyLink(tmp_path / "b", invited, ELSEWHERE)
    with pytest.raises(TimeoutError):
        await asyncio.wait_for(link.run(), 1.0)
    assert not link.complete.is_set()


async def test_a_machine_finds_the_master_that_leads_although_another_one_answers(
    leader: Leader, tmp_path: Path
) -> None:
    masters = Masters(await join(tmp_path / "m2", leader.ticket(), "m2"))
    await masters.settings()
    assert not await masters.another_leads(), "the current one does"
    async with copying(leader, tmp_path / "b"):
        await until(lambda: f"{MACHINES}/issued/m2.pem" in read_files(tmp_path / "b"))
    leader.mandate.holds = False
    assert not await masters.another_leads(), "nobody does"
    async with leading(tmp_path / "b", epoch=2) as heir:
        masters.note((str(heir.address),))
        assert await masters.another_leads()
        assert (masters.current, masters.epoch) == (str(heir.address), 2)


async def test_a_stopped_master_delays_no_machine(leader: Leader, tmp_path: Path) -> None:
    masters = Masters(await join(tmp_path / "m2", leader.ticket(), "m2"))
    silent = await asyncio.start_server(lambda *_: asyncio.sleep(60.0), LOOPBACK, 0)
    masters.note((f"tls://{LOOPBACK}:{silent.sockets[0].getsockname()[1]}",))
    assert isinstance(await asyncio.wait_for(masters.settings(), 5.0), ClusterSettings)
    await leader.far.close()
    with pytest.raises(Unavailable, match="no master leads at"):
        await asyncio.wait_for(masters.settings(), 5.0)
    silent.close()


@pytest.mark.parametrize(
    ("hello", "why"),
    [
        (StandbyHello("", 1, "0.0.1"), "runs release"),
        (StandbyHello("", 1, "9.9.9", Protocols(8, 9)), "with protocols 8 to 9"),
        (b"no hello", "not a message"),
    ],
    ids=["earlier release", "later release", "no hello"],
)
async def test_a_standby_that_cannot_take_over_is_told_why(
    leader: Leader, tmp_path: Path, hello: StandbyHello | bytes, why: str
) -> None:
    membership = await membership_of(tmp_path / "b", leader.ticket(f"b{STANDBY}"), "unused")
    assert membership is not None
    reader, writer = await dial(leader.address, membership.identity.client_context("standby"))
    stream: FrameStream[ToStandby] = FrameStream(reader, writer, ToStandby)
    if isinstance(hello, bytes):
        writer.write(len(hello).to_bytes(4, "big") + hello)
    else:
        stream.write(hello)
    answer = await receive(stream)
    assert isinstance(answer, StandbyRefused) and why in answer.refusal.text
    assert KnownMasters(leader.data / MACHINES).addresses == ()
    await stream.close()


@pytest.mark.parametrize(("name", "purpose"), [("m2", "standby"), (f"m2{STANDBY}", "control")])
async def test_machines_and_standbys_have_different_rights(
    leader: Leader, tmp_path: Path, name: str, purpose: str
) -> None:
    membership = await join(tmp_path / "m2", leader.ticket(name), name)
    reader, writer = await dial(leader.address, membership.identity.client_context(purpose))  # type: ignore[arg-type]
    stream: FrameStream[ToStandby] = FrameStream(reader, writer, ToStandby)
    stream.write(StandbyHello("", 1, __version__))
    with contextlib.suppress(ConnectionError):
        assert await receive(stream) is None
    await stream.close()
    assert leader.events.calls == []


async def test_a_ticket_of_a_machine_makes_no_standby(leader: Leader, tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="--standby NAME"):
        await membership_of(tmp_path / "b", leader.ticket(), "unused")
    with pytest.raises(NotPermitted, match="--standby NAME"):
        await join(tmp_path / "m2", leader.ticket(), f"m2{STANDBY}")


async def test_a_leader_that_was_replaced_stands_by_without_a_ticket(leader: Leader, tmp_path: Path) -> None:
    assert await membership_of(leader.data, "", "a") is None, "no other process has stood by"
    with pytest.raises(InvalidInput, match="needs a ticket of the leader once"):
        await membership_of(tmp_path / "b", "", "b")
    async with copying(leader, tmp_path / "b"):
        membership = await membership_of(leader.data, "", "a")
        assert membership is not None
        assert (membership.machine, membership.cloud) == (f"a{STANDBY}", ELSEWHERE)
        assert await membership_of(leader.data, "", "a") == membership
        invited = await membership_of(tmp_path / "b", "", "b")
        assert invited is not None and invited.machine == f"b{STANDBY}", "it was invited before"


@pytest.mark.parametrize(
    "name",
    ["../x", "machines/../../x", "/etc/passwd", "machines/issued/../x.pem", "machines/x.key", "ppaas.sqlite", ""],
)
def test_no_other_file_is_written(tmp_path: Path, name: str) -> None:
    with pytest.raises(MalformedMessage, match="no file of a standby"):
        write_file(tmp_path / "data", name, b"x")
    assert list(tmp_path.rglob("*")) == []


def test_files_are_written_and_removed_and_the_last_shows_that_all_are_there(tmp_path: Path) -> None:
    names = {LAST, f"{MACHINES}/issued/m2.pem", f"{MACHINES}/authority.key"}
    assert in_order(names)[-1] == LAST
    for name in names:
        write_file(tmp_path, name, name.encode())
    assert read_files(tmp_path) == {name: name.encode() for name in names}
    (tmp_path / MACHINES / "own").touch()
    keep_only(tmp_path, names - {LAST})
    assert read_files(tmp_path).keys() == names - {LAST}
    assert (tmp_path / MACHINES / "own").exists(), "no file of a leader"


def test_addresses_are_noted_once_the_latest_first_and_found_again(tmp_path: Path) -> None:
    masters = KnownMasters(tmp_path)
    assert masters.texts() == ()
    assert masters.note(("tls://a:1",))
    assert masters.note(("tls://b:2", "tls://[::1]:3"))
    assert not masters.note(("tls://a:1",))
    assert KnownMasters(tmp_path).addresses == masters.addresses == (
        TlsAddress("b", 2), TlsAddress("::1", 3), TlsAddress("a", 1),
    )  # fmt: skip
    assert masters.texts() == ("tls://b:2", "tls://[::1]:3", "tls://a:1")


def test_the_number_of_addresses_is_bounded(tmp_path: Path) -> None:
    masters = KnownMasters(tmp_path)
    for port in range(1, 3 * MOST):
        masters.note((f"tls://a:{port}",))
    assert [address.port for address in masters.addresses] == list(range(3 * MOST - 1, 2 * MOST - 1, -1))


def test_what_is_no_address_of_a_port_is_left_out(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    masters = KnownMasters(tmp_path)
    assert not masters.note(("unix:/run/x", "tls://", "nonsense", "tls://a:99999"))
    assert masters.addresses == ()
    assert "left out" in caplog.text


@pytest.mark.parametrize("content", ["{", '["nonsense"]', "7"])
def test_a_damaged_file_counts_as_empty(tmp_path: Path, content: str) -> None:
    (tmp_path / FILE).write_text(content)
    assert KnownMasters(tmp_path).addresses == ()
