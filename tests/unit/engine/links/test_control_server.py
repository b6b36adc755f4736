"""Tests of the control link server, with machines and strangers."""

import asyncio
import stat
from collections.abc import AsyncIterator
from pathlib import Path

import msgspec
import pytest

from engine.links.control_server import ControlServer
from engine.protocols import control_link
from engine.protocols.refusals import Refusal
from engine.specs.start_state import KernelProgress
from ppaas.errors import PPaaSError, Unavailable
from tests.support.engine.engine_links import connection, dial_control, receive, register
from tests.support.waiting import until

SECRET = "secret"


class OldRegister(msgspec.Struct, tag="register"):
    """First frame of an agent of another release."""

    machine_id: str = "m1"


class Deputy:
    """A mandate that a test gives and takes."""

    def __init__(self, epoch: int) -> None:
        self.epoch = epoch
        self.holds = True
        self.heard = 0

    def leads(self) -> bool:
        return self.holds

    def heard_of(self, epoch: int) -> None:
        self.heard = max(self.heard, epoch)
        self.holds = self.holds and epoch <= self.epoch


class Events:
    """Records the events."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, str]] = []
        self.reports: list[control_link.FromAgent] = []
        self.kernels: list[KernelProgress | None] = []
        self.refusal: PPaaSError | None = None

    def machine_starting(self, machine: str, kernels: KernelProgress | None) -> None:
        self.calls.append(("starting", machine))
        self.kernels.append(kernels)

    def machine_start_ended(self, machine: str) -> None:
        self.calls.append(("start ended", machine))

    async def machine_registered(self, register: control_link.Register) -> None:
        if self.refusal is not None:
            raise self.refusal
        self.calls.append(("registered", register.machine))

    def machine_said(self, machine: str, event: control_link.FromAgent) -> None:
        self.calls.append(("reported", machine))
        self.reports.append(event)

    def machine_gone(self, machine: str) -> None:
        self.calls.append(("gone", machine))


@pytest.fixture
def events() -> Events:
    return Events()


@pytest.fixture
async def server(tmp_path: Path, events: Events) -> AsyncIterator[ControlServer]:
    opened = ControlServer(tmp_path / "control.sock", SECRET, events, register_timeout=5.0)
    await opened.start()
    yield opened
    await opened.close()


async def test_socket_is_accessible_to_its_user_only(server: ControlServer) -> None:
    assert stat.S_IMODE(server.path.stat().st_mode) == 0o600


async def test_machine_registers_receives_orders_and_reports(server: ControlServer, events: Events) -> None:
    stream = await dial_control(server.path)
    stream.write(register("m1"))
    await until(lambda: events.calls)
    server.order("m1", control_link.StopContainer("c1"))
    assert await receive(stream) == control_link.StopContainer("c1")
    news = [
        control_link.Heartbeat(0.5, 1 << 20, [control_link.ContainerLoad("c1", 0.25, 1 << 10)]),
        control_link.Launched("c1", 42),
        control_link.LaunchFailed("c2", Refusal("unavailable", "no room")),
        control_link.Exited("c1", -9),
    ]
    for event in news:
        stream.write(event)
    await stream.close()
    await until(lambda: ("gone", "m1") in events.calls)
    assert events.reports == news
    assert events.calls == [("registered", "m1"), *[("reported", "m1")] * 4, ("gone", "m1")]


@pytest.mark.parametrize(
    "first",
    [register("m1", "wrong"), register("m1", ""), register("m1", "geheimnisträger"), control_link.Launched("c1", 1)],
    ids=["wrong secret", "no secret", "odd secret", "no registration"],
)
async def test_unknown_client_is_disconnected_without_an_event(
    server: ControlServer, events: Events, first: msgspec.Struct, caplog: pytest.LogCaptureFixture
) -> None:
    stream = await dial_control(server.path)
    stream.write(first)
    assert await receive(stream) is None
    assert events.calls == []
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    with pytest.raises(Unavailable, match="m1"):
        server.order("m1", control_link.StopContainer("c1"))


async def test_agent_of_another_release_is_dismissed(server: ControlServer, events: Events) -> None:
    stream = await dial_control(server.path)
    stream.write(OldRegister())
    assert await receive(stream) == control_link.Dismissed()
    assert await receive(stream) is None
    assert events.calls == []


@pytest.mark.parametrize("named", ["m2", "m1"], ids=["own name", "name of another"])
async def test_remote_machine_registers_only_under_its_certificates_name(
    server: ControlServer, events: Events, named: str
) -> None:
    stream, reader, writer = await connection(control_link.ToAgent)
    serving = asyncio.create_task(server.connected(reader, writer, "m2"))
    await stream.send(register(named, secret=""))
    await until(lambda: events.calls or serving.done())
    assert events.calls == ([("registered", "m2")] if named == "m2" else [])
    await stream.close()
    await serving


async def test_silent_client_is_disconnected(tmp_path: Path, events: Events, caplog: pytest.LogCaptureFixture) -> None:
    server = ControlServer(tmp_path / "control.sock", SECRET, events, register_timeout=0.05)
    await server.start()
    stream = await dial_control(server.path)
    assert await receive(stream) is None
    await server.close()
    assert events.calls == []
    assert "the machine did not register in time" in caplog.text


async def test_second_machine_of_the_same_name_is_refused(server: ControlServer, events: Events) -> None:
    first = await dial_control(server.path)
    first.write(register("m1"))
    await until(lambda: events.calls)
    second = await dial_control(server.path)
    second.write(register("m1"))
    assert await receive(second) is None
    server.order("m1", control_link.StopContainer("c1"))
    assert await receive(first) == control_link.StopContainer("c1")
    assert events.calls == [("registered", "m1")]
    await first.close()


async def test_machine_name_is_free_after_disconnection(server: ControlServer, events: Events) -> None:
    for _ in range(2):
        events.calls.clear()
        stream = await dial_control(server.path)
        stream.write(register("m1"))
        await until(lambda: events.calls == [("registered", "m1")])
        await stream.close()
        await until(lambda: events.calls == [("registered", "m1"), ("gone", "m1")])
        with pytest.raises(Unavailable):
            server.order("m1", control_link.StopContainer("c1"))


async def test_machine_that_sends_invalid_frames_is_dismissed(server: ControlServer, events: Events) -> None:
    stream = await dial_control(server.path)
    stream.write(register("m1"))
    stream.write(control_link.StopContainer("no agent says this"))
    await until(lambda: ("gone", "m1") in events.calls)
    assert await receive(stream) == control_link.Dismissed()
    assert await receive(stream) is None


async def test_disconnected_machine_may_return_and_dismissed_one_is_notified(
    server: ControlServer, events: Events
) -> None:
    for dismissed in (False, True):
        stream = await dial_control(server.path)
        stream.write(register("m1"))
        await until(lambda: events.calls[-1:] == [("registered", "m1")])
        if dismissed:
            await server.dismiss("m1")
            assert await receive(stream) == control_link.Dismissed()
        else:
            server.hang_up("m1")
        assert await receive(stream) is None
        await until(lambda: events.calls[-1:] == [("gone", "m1")])


async def test_machine_is_not_dismissed_while_the_store_is_unavailable(server: ControlServer, events: Events) -> None:
    events.refusal = Unavailable("the store is away")
    stream = await dial_control(server.path)
    stream.write(register("m1"))
    assert await receive(stream) is None, "so it tries again"


async def test_closing_dismisses_registered_and_unregistered_machines(server: ControlServer, events: Events) -> None:
    known, silent = await dial_control(server.path), await dial_control(server.path)
    known.write(register("m1"))
    await until(lambda: events.calls)
    await server.close()
    assert await receive(known) == await receive(silent) == control_link.Dismissed()
    assert await receive(known) is None
    assert await receive(silent) is None
    await until(lambda: ("gone", "m1") in events.calls)
    assert not server.path.exists()


async def test_orders_and_dismissals_wait_while_the_master_does_not_lead(server: ControlServer, events: Events) -> None:
    server.mandate = deputy = Deputy(2)
    stream = await dial_control(server.path)
    stream.write(register("m1", epoch=2))
    await until(lambda: events.calls)
    deputy.holds = False
    orders = [control_link.StopContainer("c1"), control_link.StopContainer("c2")]
    for order in orders:
        server.order("m1", order)
    stream.write(control_link.AgentBeat())
    assert await receive(stream) == control_link.BeatAcknowledged(leads=False)
    deputy.holds = True
    server.resume()
    assert [await receive(stream) for _ in orders] == orders
    stream.write(control_link.AgentBeat())
    assert await receive(stream) == control_link.BeatAcknowledged(leads=True)
    deputy.holds = False
    await server.close()
    assert await receive(stream) is None, "it is disconnected, and not dismissed"


@pytest.mark.parametrize("late", [False, True], ids=["when it registers", "when it is welcome"])
async def test_a_master_learns_from_a_machine_that_it_was_replaced(
    server: ControlServer, events: Events, late: bool
) -> None:
    server.mandate = deputy = Deputy(2)
    stream = await dial_control(server.path)
    stream.write(register("m1", epoch=0 if late else 3))
    if late:
        stream.write(control_link.Outranked(3))
    assert await receive(stream) is None, "it is disconnected, and not dismissed"
    assert deputy.heard == 3
    assert events.calls == ([("registered", "m1"), ("gone", "m1")] if late else [])


async def test_a_machine_reports_its_start_until_it_closes_the_connection(
    server: ControlServer, events: Events
) -> None:
    stream = await dial_control(server.path)
    progress = KernelProgress(1, 3)
    stream.write(control_link.MachineStarting("m1", SECRET))
    stream.write(control_link.MachineStarting("m1", SECRET, progress))
    await until(lambda: len(events.calls) == 2)
    assert events.kernels == [None, progress]
    await stream.close()
    await until(lambda: len(events.calls) == 3)
    assert events.calls == [("starting", "m1"), ("starting", "m1"), ("start ended", "m1")]


@pytest.mark.parametrize(
    "frames",
    [
        [control_link.MachineStarting("m1", "wrong")],
        [control_link.MachineStarting("m1", SECRET), register("m1")],
        [control_link.MachineStarting("m1", SECRET), control_link.AgentBeat()],
    ],
    ids=["wrong secret", "registration", "heartbeat"],
)
async def test_other_frames_than_reports_of_a_start_close_the_connection(
    server: ControlServer, events: Events, frames: list[msgspec.Struct]
) -> None:
    stream = await dial_control(server.path)
    for frame in frames:
        stream.write(frame)
    assert await receive(stream) is None
    assert not {what for what, _ in events.calls} - {"starting", "start ended"}


async def test_a_machine_of_another_host_reports_its_own_start_only(server: ControlServer, events: Events) -> None:
    stream, reader, writer = await connection(control_link.ToAgent)
    serving = asyncio.create_task(server.connected(reader, writer, machine="m1"))
    stream.write(control_link.MachineStarting("m2", ""))
    await asyncio.wait_for(serving, 10)
    assert events.calls == []
