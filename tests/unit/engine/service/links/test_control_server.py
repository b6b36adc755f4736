"""Tests of the control link server, with machines and strangers."""

import asyncio
import stat
from collections.abc import AsyncIterator
from pathlib import Path

import msgspec
import pytest

from engine.protocols import control_link
from engine.protocols.robot_link import Refusal
from engine.service.links.control_server import ControlServer
from ppaas.errors import PPaaSError, Unavailable
from tests.support.engine.engine_links import connection, dial_control, receive, register
from tests.support.waiting import until

SECRET = "secret"


class Otherwise(msgspec.Struct, tag="register"):
    """First frame of an agent of another release."""

    machine_id: str = "m1"


class Events:
    """Records the events."""

    def __init__(self) -> None:
        self.told: list[tuple[str, str]] = []
        self.said: list[control_link.FromAgent] = []
        self.refusal: PPaaSError | None = None

    async def machine_registered(self, register: control_link.Register) -> None:
        if self.refusal is not None:
            raise self.refusal
        self.told.append(("registered", register.machine))

    def machine_said(self, machine: str, event: control_link.FromAgent) -> None:
        self.told.append(("said", machine))
        self.said.append(event)

    def machine_gone(self, machine: str) -> None:
        self.told.append(("gone", machine))


@pytest.fixture
def events() -> Events:
    return Events()


@pytest.fixture
async def server(tmp_path: Path, events: Events) -> AsyncIterator[ControlServer]:
    opened = ControlServer(tmp_path / "control.sock", SECRET, events, register_timeout=5.0)
    await opened.start()
    yield opened
    await opened.close()


async def test_only_this_user_may_dial(server: ControlServer) -> None:
    assert stat.S_IMODE(server.path.stat().st_mode) == 0o600


async def test_a_machine_registers_takes_orders_and_tells(server: ControlServer, events: Events) -> None:
    stream = await dial_control(server.path)
    stream.write(register("m1"))
    await until(lambda: events.told)
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
    await until(lambda: ("gone", "m1") in events.told)
    assert events.said == news
    assert events.told == [("registered", "m1"), *[("said", "m1")] * 4, ("gone", "m1")]


@pytest.mark.parametrize(
    "first",
    [register("m1", "wrong"), register("m1", ""), register("m1", "geheimnisträger"), control_link.Launched("c1", 1)],
    ids=["wrong secret", "no secret", "odd secret", "no registration"],
)
async def test_a_stranger_is_hung_up_on_and_nobody_is_told(
    server: ControlServer, events: Events, first: msgspec.Struct, caplog: pytest.LogCaptureFixture
) -> None:
    stream = await dial_control(server.path)
    stream.write(first)
    assert await receive(stream) is None
    assert events.told == []
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    with pytest.raises(Unavailable, match="m1"):
        server.order("m1", control_link.StopContainer("c1"))


async def test_one_that_registers_as_another_release_might_is_dismissed_so_that_it_waits_for_nobody(
    server: ControlServer, events: Events
) -> None:
    stream = await dial_control(server.path)
    stream.write(Otherwise())
    assert await receive(stream) == control_link.Dismissed()
    assert await receive(stream) is None
    assert events.told == []


@pytest.mark.parametrize("named", ["m2", "m1"], ids=["own name", "name of another"])
async def test_a_machine_of_another_host_registers_under_the_name_of_its_certificate_alone(
    server: ControlServer, events: Events, named: str
) -> None:
    stream, reader, writer = await connection(control_link.ToAgent)
    serving = asyncio.create_task(server.connected(reader, writer, "m2"))
    await stream.send(register(named, secret=""))
    await until(lambda: events.told or serving.done())
    assert events.told == ([("registered", "m2")] if named == "m2" else [])
    await stream.close()
    await serving


async def test_silence_is_cut_off(tmp_path: Path, events: Events) -> None:
    server = ControlServer(tmp_path / "control.sock", SECRET, events, register_timeout=0.05)
    await server.start()
    stream = await dial_control(server.path)
    assert await receive(stream) is None
    await server.close()
    assert events.told == []


async def test_a_second_machine_of_a_name_is_refused_and_the_first_goes_on(
    server: ControlServer, events: Events
) -> None:
    first = await dial_control(server.path)
    first.write(register("m1"))
    await until(lambda: events.told)
    second = await dial_control(server.path)
    second.write(register("m1"))
    assert await receive(second) is None
    server.order("m1", control_link.StopContainer("c1"))
    assert await receive(first) == control_link.StopContainer("c1")
    assert events.told == [("registered", "m1")]
    await first.close()


async def test_a_name_is_free_again_when_its_machine_has_gone(server: ControlServer, events: Events) -> None:
    for _ in range(2):
        events.told.clear()
        stream = await dial_control(server.path)
        stream.write(register("m1"))
        await until(lambda: events.told == [("registered", "m1")])
        await stream.close()
        await until(lambda: events.told == [("registered", "m1"), ("gone", "m1")])
        with pytest.raises(Unavailable):
            server.order("m1", control_link.StopContainer("c1"))


async def test_a_machine_that_talks_rubbish_is_gone(server: ControlServer, events: Events) -> None:
    stream = await dial_control(server.path)
    stream.write(register("m1"))
    stream.write(control_link.StopContainer("no agent says this"))
    await until(lambda: ("gone", "m1") in events.told)
    assert await receive(stream) == control_link.Dismissed()
    assert await receive(stream) is None


async def test_a_machine_that_is_hung_up_on_may_come_again_and_one_that_is_dismissed_is_told_so(
    server: ControlServer, events: Events
) -> None:
    for dismissed in (False, True):
        stream = await dial_control(server.path)
        stream.write(register("m1"))
        await until(lambda: events.told[-1:] == [("registered", "m1")])
        if dismissed:
            await server.dismiss("m1")
            assert await receive(stream) == control_link.Dismissed()
        else:
            server.hang_up("m1")
        assert await receive(stream) is None
        await until(lambda: events.told[-1:] == [("gone", "m1")])


async def test_a_machine_is_not_dismissed_while_nobody_can_tell_whose_clones_it_carries(
    server: ControlServer, events: Events
) -> None:
    events.refusal = Unavailable("the store is away")
    stream = await dial_control(server.path)
    stream.write(register("m1"))
    assert await receive(stream) is None, "so it tries again"


async def test_closing_lets_all_machines_go_even_those_that_have_not_registered(
    server: ControlServer, events: Events
) -> None:
    known, silent = await dial_control(server.path), await dial_control(server.path)
    known.write(register("m1"))
    await until(lambda: events.told)
    await server.close()
    assert await receive(known) == await receive(silent) == control_link.Dismissed()
    assert await receive(known) is None
    assert await receive(silent) is None
    await until(lambda: ("gone", "m1") in events.told)
    assert not server.path.exists()
