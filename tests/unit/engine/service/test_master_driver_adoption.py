"""Tests of machines that reconnect to a new cloud process with their containers: real links, no processes."""

import math
from collections.abc import AsyncIterator
from pathlib import Path

import msgspec
import pytest

from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.protocols import control_link, robot_link
from engine.service.master_driver import MasterDriver
from engine.specs.checkpoints import CheckpointSelection, marks
from engine.specs.containers import ContainerSpec
from ppaas.errors import Unavailable
from storage.memory.store import MemoryStore
from storage.records import CloneCheckpoint
from tests.support.engine.engine_links import dial_link, hello, receive
from tests.support.engine.fake_machine import FakeMachine
from tests.support.engine.listening import Listening
from tests.support.engine.remembering_listener import RememberingListener
from tests.support.engine.specs import robot_request
from tests.support.waiting import until


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture
def told() -> RememberingListener:
    return RememberingListener()


@pytest.fixture
async def service(tmp_path: Path, store: MemoryStore, told: RememberingListener) -> AsyncIterator[MasterDriver]:
    opened = MasterDriver(Master(FirstFit()), CheckpointSelection(store, "this"), tmp_path, "secret", told)
    await opened.start()
    yield opened
    await opened.close()


def running(container: str = "old", robot: str = "tb1") -> control_link.RunningContainer:
    request = robot_request(robot)
    spec = ContainerSpec(container, request.user, request.map, request.cores, request.robot, session="s")
    return control_link.RunningContainer(spec, spec.cores, "its secret", 42)


def keep(store: MemoryStore, carried: control_link.RunningContainer, instance: str = "before") -> None:
    """Store a checkpoint of a container as the last one of its robot."""
    spec = carried.spec
    assert spec.robot is not None
    store.save_clone(CloneCheckpoint(spec.user, spec.robot.id, marks(spec, instance), 1.0))


async def test_a_robot_finds_the_container_that_it_had(
    service: MasterDriver, store: MemoryStore, tmp_path: Path, told: RememberingListener
) -> None:
    keep(store, running())
    machine = await FakeMachine.join(tmp_path, carries=(running(), running("older"), running("unkept", "tb2")))
    assert await machine.welcome == control_link.Welcome("this", ("old",))
    assert told.adopted == [robot_request().key]
    stream = await dial_link(service.servers[1].path)
    stream.write(hello("old", "its secret", 42, applied=57))
    client, place = Listening(), service.open_place(robot_request())
    number = place.join(client)
    await place.ready(10)
    place.deliver("goal", b"1", number, must_arrive=True)
    assert await receive(stream) == robot_link.Deliver("goal", b"1", number, 58)
    (seen,) = service.containers("ann")
    assert (seen.id, seen.pid, seen.machine, seen.state) == ("old", 42, "m1", "ready")
    assert [view.containers for view in service.machines()] == [1]
    assert not machine.has_orders(), "nothing was started"
    await stream.close()
    await machine.leave()


async def test_one_that_does_not_say_hello_is_replaced_from_its_checkpoint(store: MemoryStore, tmp_path: Path) -> None:
    service = MasterDriver(
        Master(FirstFit()), CheckpointSelection(store, "this"), tmp_path, "secret", start_timeout=0.05
    )
    await service.start()
    keep(store, running())
    machine = await FakeMachine.join(tmp_path, carries=(running(),))
    assert await machine.stopped() == "old"
    order = await machine.started()
    assert order.spec.session == "s" and order.spec.checkpoint
    await machine.leave()
    await service.close()


async def test_robots_wait_for_machines_that_may_return_but_not_for_long(
    service: MasterDriver, store: MemoryStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.service.machine_events.RETURN_TIMEOUT", 0.1)
    service.of_machines.expect_back(["m1", "m2"])
    keep(store, running())
    first = await FakeMachine.join(tmp_path, "m1")
    await first.welcome
    place = service.open_place(robot_request())
    with pytest.raises(Unavailable):
        await place.ready(0.01)
    assert not first.has_orders()
    assert (await first.started()).spec.robot == robot_request().robot
    second = await FakeMachine.join(tmp_path, "m2", carries=(running(),))
    assert await second.welcome == control_link.Welcome("this"), "it is served elsewhere by now"
    await first.leave()
    await second.leave()


async def test_a_machine_that_the_cloud_lost_itself_brings_nothing_back(
    service: MasterDriver, store: MemoryStore, tmp_path: Path
) -> None:
    keep(store, running(), "this")
    machine = await FakeMachine.join(tmp_path, carries=(running(),))
    assert await machine.welcome == control_link.Welcome("this")
    assert service.containers(None) == []
    await machine.leave()


async def test_a_machine_of_another_release_is_sent_away_and_its_robots_go_on_from_their_checkpoints(
    store: MemoryStore, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    service = MasterDriver(Master(FirstFit()), CheckpointSelection(store, "this", math.inf), tmp_path, "secret")
    await service.start()
    service.of_machines.expect_back(["m1"])
    keep(store, running())
    old = await FakeMachine.join(tmp_path, carries=(running(),), release="0.0.9")
    assert await old.order() is None and old.dismissed, "so that it ends all that it carries"
    assert "'m1' runs release 0.0.9, but this cloud" in caplog.text
    service.open_place(robot_request())
    new = await FakeMachine.join(tmp_path)
    order = await new.started()
    assert order.spec.robot == robot_request().robot and order.spec.checkpoint
    await new.leave()
    await service.close()


async def test_a_container_that_hangs_up_and_lives_is_replaced(service: MasterDriver, tmp_path: Path) -> None:
    machine = await FakeMachine.join(tmp_path)
    service.open_place(robot_request())
    container = await machine.boot(await machine.started())
    await until(lambda: service.containers(None)[0].state == "ready")
    await container.stream.close()
    assert await machine.stopped() == container.spec.id
    await machine.leave()


async def test_what_a_machine_tells_is_refused_while_the_store_is_away(
    service: MasterDriver, store: MemoryStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_: object) -> None:
        raise Unavailable("the store is away")

    with monkeypatch.context() as patched:
        patched.setattr(store, "clone", away)
        machine = await FakeMachine.join(tmp_path, carries=(running(),))
        assert await machine.order() is None and not machine.dismissed, "so it keeps what it carries, and tries again"
    keep(store, running())
    again = await FakeMachine.join(tmp_path, carries=(running(),))
    assert (await again.welcome).adopted == ("old",)
    await again.leave()
    await machine.leave()


async def test_the_names_of_machines_are_told_as_they_come_and_go(
    service: MasterDriver, tmp_path: Path, told: RememberingListener
) -> None:
    machine = await FakeMachine.join(tmp_path)
    await until(lambda: told.machines == [["m1"]])
    await machine.leave()
    await until(lambda: told.machines == [["m1"], []])


def test_specs_come_back_as_they_went() -> None:
    """Otherwise a repeated request would look like one for another robot."""
    told = running()
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(told), type=control_link.RunningContainer) == told
