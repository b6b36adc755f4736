"""Tests of draining and removal of machines while robots are connected: real links, no processes."""

import asyncio
from collections.abc import AsyncIterator
from functools import partial
from pathlib import Path

import pytest

from engine.control.master_driver import MasterDriver
from engine.control.views import MachineView
from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.protocols import control_link, robot_link, session_frames
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import SESSION_STATE
from engine.specs.machine_settings import MachineSettings
from engine.specs.start_state import READY, KernelProgress, StartState
from ppaas.errors import Conflict, NotFound, Starting
from storage.memory.store import MemoryStore
from storage.records import CloneCheckpoint
from tests.support.engine.at_once import at_once
from tests.support.engine.engine_links import dial_control, dial_link, hello
from tests.support.engine.fake_machine import FakeMachine
from tests.support.engine.listening import Listening
from tests.support.engine.remembering_listener import RememberingListener
from tests.support.engine.specs import robot_request
from tests.support.waiting import until

DRAINING = MachineSettings(draining=True)


def seen(service: MasterDriver) -> list[MachineView]:
    """Return the machines, as operators see them."""
    return at_once(service.administration.views())


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture
async def service(tmp_path: Path, store: MemoryStore) -> AsyncIterator[MasterDriver]:
    opened = MasterDriver(Master(FirstFit()), CheckpointSelection(store), tmp_path, "secret")
    await opened.start()
    yield opened
    await opened.close()


@pytest.fixture
async def machines(service: MasterDriver, tmp_path: Path) -> AsyncIterator[list[FakeMachine]]:
    joined = []
    for name in ("m1", "m2"):
        joined.append(await FakeMachine.join(tmp_path, name))
        await until(lambda: len(seen(service)) == len(joined))
    yield joined
    for machine in joined:
        await machine.leave()


async def test_robot_keeps_its_session_when_its_machine_is_drained(
    service: MasterDriver, machines: list[FakeMachine], store: MemoryStore
) -> None:
    place, client = service.open_place(robot_request()), Listening()
    number = place.join(client)
    first = await machines[0].boot(await machines[0].started())
    await place.ready(10)
    place.subscribe("map", number)
    assert isinstance(await first.next(), robot_link.SubscribeTopic)
    await service.administration.configure("m1", DRAINING)
    assert await first.next() == robot_link.Shutdown()
    assert await machines[0].stopped() == first.spec.id
    assert not machines[1].has_orders(), "nothing starts before the checkpoint is stored"
    store.save_clone(CloneCheckpoint("ann", "tb1", {SESSION_STATE: first.spec.id.encode(), "amcl": b"{}"}, 1.0))
    place.deliver("goal", b"1", number, must_arrive=True)
    await machines[0].kill(first, 0)
    order = await machines[1].started()
    assert order.spec.checkpoint["amcl"] == b"{}"
    second = await machines[1].boot(order)
    assert [await second.next(), await second.next()] == [
        robot_link.SubscribeTopic("map", 0),
        robot_link.Deliver("goal", b"1", number, 1),
    ]
    assert [view.machine for view in at_once(service.containers.views("ann"))] == ["m2"]
    assert {view.id: view.state for view in seen(service)} == {"m1": "drained", "m2": "ready"}
    assert client.reasons == []


async def test_next_container_leaves_when_the_previous_is_ready(
    service: MasterDriver, machines: list[FakeMachine], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.master.master.MOVES", 1)
    ran = []
    for robot in ("tb1", "tb2"):
        place = service.open_place(robot_request(robot))
        ran.append(await machines[0].boot(await machines[0].started()))
        await place.ready(10)
    await service.administration.configure("m1", DRAINING)
    assert seen(service)[0].state == "draining"
    for container in ran:
        assert await machines[0].stopped() == container.spec.id
        assert not machines[0].has_orders()
        await machines[0].kill(container, 0)
        await machines[1].boot(await machines[1].started())
    await until(lambda: all(view.state == "ready" for view in at_once(service.containers.views("ann"))))


async def test_removed_machine_is_disconnected_until_it_is_admitted(
    service: MasterDriver, machines: list[FakeMachine], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    service.open_place(robot_request())
    first = await machines[0].started()
    with pytest.raises(Conflict):
        await service.administration.remove("m1")
    await service.administration.remove("m1", force=True)
    assert await machines[0].order() is None
    order = await machines[1].started()
    assert order.spec.id != first.spec.id
    with pytest.raises(NotFound):
        await service.administration.configure("m1", DRAINING)
    again = await FakeMachine.join(tmp_path, "m1")
    assert await again.order() is None
    assert "was removed" in caplog.text
    assert service.counts.machines_lost == 0, "it did not leave by itself"
    assert [view.id for view in seen(service)] == ["m2"]
    await service.administration.admit("m1")
    admitted = await FakeMachine.join(tmp_path, "m1")
    await until(lambda: len(seen(service)) == 2)
    await admitted.leave()
    await again.leave()


async def test_listener_is_notified_of_a_removed_machine(tmp_path: Path) -> None:
    listener = RememberingListener()
    service = MasterDriver(Master(FirstFit()), CheckpointSelection(MemoryStore()), tmp_path, "secret", listener)
    await service.start()
    machine = await FakeMachine.join(tmp_path)
    await service.wait_for_machine(10)
    await service.administration.remove("m1")
    assert listener.removed == ["m1"]
    await service.close()
    await machine.leave()


# -- round trips and load ---------------------------------------------------------------------------------------------


async def test_measured_round_trips_and_network_load_are_listed(
    service: MasterDriver, machines: list[FakeMachine], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.processes.heartbeats.BEAT_PERIOD", 0.01)
    place = service.open_place(robot_request())
    container = await machines[0].boot(await machines[0].started())
    await place.ready(10)
    place.note_round_trip(0.04)
    assert await container.next() == session_frames.RoundTrip(0.04)
    container.stream.write(robot_link.ContainerBeat(busy=False, round_trip=0.04))
    await until(lambda: at_once(service.containers.views("ann"))[0].round_trip is not None)
    machines[0].tell(control_link.Heartbeat(0.5, 1 << 20, [], 3e6, {"m2": 0.02}))
    await until(lambda: seen(service)[0].round_trips and service._master.machines["m1"].served)
    machines[0].tell(control_link.Heartbeat(0.5, 1 << 20, [], 3e6, {"m2": 0.02}))
    await until(lambda: seen(service)[0].round_trip != 0.02)
    view = seen(service)[0]
    assert (view.network, view.network_used, view.round_trips) == (None, 3e6, {"m2": 0.02})
    assert view.round_trip == pytest.approx((0.02 + 0.04) / 2)
    assert at_once(service.containers.views("ann"))[0].round_trip == 0.04


# -- invalid reports ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("cores", "name"), [(0, "m3"), (-1, "m3"), (1 << 20, "m3"), (2, "../m3"), (2, "")], ids=str)
async def test_invalid_registration_is_disconnected(
    service: MasterDriver, machines: list[FakeMachine], tmp_path: Path, cores: int, name: str
) -> None:
    liar = await FakeMachine.join(tmp_path, name, cores=cores)
    assert await liar.order() is None
    assert [view.id for view in seen(service)] == ["m1", "m2"]
    await liar.leave()


async def test_second_machine_of_the_same_name_does_not_affect_the_first(
    service: MasterDriver, machines: list[FakeMachine], tmp_path: Path
) -> None:
    place = service.open_place(robot_request())
    first = await machines[0].boot(await machines[0].started())
    await place.ready(10)
    double = await FakeMachine.join(tmp_path, "m1", cores=64)
    assert await double.order() is None
    assert [(view.id, view.cores, view.containers) for view in seen(service)] == [
        ("m1", 2, 1),
        ("m2", 2, 0),
    ]
    assert place.container == first.spec.id
    await double.leave()


async def test_machine_that_reports_a_foreign_container_is_disconnected(
    service: MasterDriver, machines: list[FakeMachine], caplog: pytest.LogCaptureFixture
) -> None:
    place = service.open_place(robot_request())
    first = await machines[0].boot(await machines[0].started())
    await place.ready(10)
    machines[1].tell(control_link.Exited(first.spec.id, -9))
    assert await machines[1].order() is None
    assert "of another machine" in caplog.text
    assert place.container == first.spec.id
    await until(lambda: [view.id for view in seen(service)] == ["m1"])


async def test_machine_with_an_impossible_load_is_disconnected(
    service: MasterDriver, machines: list[FakeMachine]
) -> None:
    service.open_place(robot_request())
    order = await machines[0].started()
    machines[0].tell(control_link.Heartbeat(0.5, 1 << 50, []))
    assert await machines[0].order() is None
    again = await machines[1].started()
    assert again.spec.session == order.spec.id


PROGRESS = KernelProgress(12, 107)


async def test_a_cloud_is_starting_until_its_first_machine_has_joined(service: MasterDriver, tmp_path: Path) -> None:
    assert service.start_state() == READY  # as one of Ray, none of whose machines is expected at its start
    service.of_machines.await_machine("m1")
    assert service.start_state() == StartState(ready=False, machines={"m1": None})
    reports = await dial_control(tmp_path / "control.sock")
    reports.write(control_link.MachineStarting("m1", "secret", PROGRESS))
    await until(lambda: service.start_state() == StartState(ready=False, machines={"m1": PROGRESS}))
    assert [(view.id, view.state, view.kernels) for view in seen(service)] == [("m1", "starting", PROGRESS)]
    await reports.close()
    machine = await FakeMachine.join(tmp_path, "m1")
    await until(lambda: service.start_state() == READY)
    machine._stream.write(control_link.AgentBeat(kernels=PROGRESS))
    await until(lambda: service.start_state() == StartState(machines={"m1": PROGRESS}))
    assert [(view.id, view.state, view.kernels) for view in seen(service)] == [("m1", "ready", PROGRESS)]
    machine._stream.write(control_link.AgentBeat())
    await until(lambda: service.start_state() == READY)
    await machine.leave()


async def test_a_machine_that_starts_beside_a_ready_one_keeps_no_request_waiting(
    service: MasterDriver, machines: list[FakeMachine], tmp_path: Path
) -> None:
    reports = await dial_control(tmp_path / "control.sock")
    reports.write(control_link.MachineStarting("m3", "secret", PROGRESS))
    await until(lambda: service.start_state() == StartState(machines={"m3": PROGRESS}))
    for request in (
        service.administration.settings,
        service.administration.remove,
        partial(service.administration.configure, settings=MachineSettings()),
    ):
        with pytest.raises(Starting, match="machine 'm3' is starting: wait until it has joined"):
            await request("m3")  # it is listed, hence not unknown
    await reports.close()
    await until(lambda: service.start_state() == READY)


async def test_heartbeats_of_a_container_that_compiles_come_from_its_own_machine(
    service: MasterDriver, machines: list[FakeMachine]
) -> None:
    place = service.open_place(robot_request())
    container = await machines[0].boot(await machines[0].started())
    await place.ready(10)
    before = place.beats
    machines[1]._stream.write(control_link.AgentBeat(compiling=(container.spec.id,)))
    machines[0]._stream.write(control_link.AgentBeat(compiling=("another",)))
    machines[0]._stream.write(control_link.AgentBeat(compiling=(container.spec.id,)))
    await until(lambda: place.beats > before)
    assert place.beats == before + 1


async def test_a_container_that_waits_for_kernels_is_not_given_up(tmp_path: Path, store: MemoryStore) -> None:
    opened = MasterDriver(Master(FirstFit()), CheckpointSelection(store), tmp_path, "secret", start_timeout=0.5)
    await opened.start()
    machine = await FakeMachine.join(tmp_path, "m1")
    await until(lambda: seen(opened))
    place = opened.open_place(robot_request())
    order = await machine.started()
    stream = await dial_link(order.link)
    for _ in range(20):
        stream.write(robot_link.KernelsAwaited(order.spec.id, order.secret))
        await asyncio.sleep(0.1)
    assert not machine.has_orders()
    stream.write(hello(order.spec.id, order.secret))
    await place.ready(10)
    await stream.close()
    await machine.leave()
    await opened.close()
