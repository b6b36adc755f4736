"""Tests of machines that reconnect to a new cloud process with their containers: real links, no processes."""

import math
from collections.abc import AsyncIterator
from pathlib import Path

import msgspec
import pytest

from engine.control.master_driver import MasterDriver
from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.protocols import control_link, robot_link
from engine.specs.checkpoints import CheckpointSelection, marks
from engine.specs.containers import ContainerSpec
from ppaas.errors import Unavailable
from storage.memory.store import MemoryStore
from storage.records import CloneCheckpoint
from tests.support.engine.at_once import at_once
from tests.support.engine.engine_links import dial_link, hello, receive
from tests.support.engine.fake_machine import FakeMachine
from tests.support.engine.listening import Listening
from tests.support.engine.remembering_listener import RememberingListener
from tests.support.engine.specs import coordinator_request, coordinator_spec, robot_request
from tests.support.waiting import until


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


@pytest.fixture
def listener() -> RememberingListener:
    return RememberingListener()


@pytest.fixture
async def service(tmp_path: Path, store: MemoryStore, listener: RememberingListener) -> AsyncIterator[MasterDriver]:
    opened = MasterDriver(Master(FirstFit()), CheckpointSelection(store, "this"), tmp_path, "secret", listener)
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
    store.save_clone(CloneCheckpoint(spec.user, spec.checkpoint_name, marks(spec, instance), 1.0))


async def test_robot_reconnects_to_its_adopted_container(
    service: MasterDriver, store: MemoryStore, tmp_path: Path, listener: RememberingListener
) -> None:
    keep(store, running())
    machine = await FakeMachine.join(tmp_path, carries=(running(), running("older"), running("unkept", "tb2")))
    assert await machine.welcome == control_link.Welcome("this", ("old",))
    assert listener.adopted == [robot_request().key]
    stream = await dial_link(service.servers[1].path)
    stream.write(hello("old", "its secret", 42, applied=57))
    client, place = Listening(), service.open_place(robot_request())
    number = place.join(client)
    await place.ready(10)
    place.deliver("goal", b"1", number, must_arrive=True)
    assert await receive(stream) == robot_link.Deliver("goal", b"1", number, 58)
    (seen,) = at_once(service.containers.views("ann"))
    assert (seen.id, seen.pid, seen.machine, seen.state) == ("old", 42, "m1", "ready")
    assert [view.containers for view in at_once(service.administration.views())] == [1]
    assert not machine.has_orders(), "nothing was started"
    await stream.close()
    await machine.leave()


async def test_a_coordinator_is_adopted_for_its_group(
    service: MasterDriver, store: MemoryStore, tmp_path: Path, listener: RememberingListener
) -> None:
    spec = msgspec.structs.replace(coordinator_spec("old"), session="s")
    carried = control_link.RunningContainer(spec, spec.cores, "its secret", 42)
    keep(store, carried)
    keep(store, running("clone"))
    machine = await FakeMachine.join(tmp_path, carries=(carried, running("clone")))
    assert await machine.welcome == control_link.Welcome("this", ("old", "clone"))
    assert listener.adopted == [coordinator_request().key, robot_request().key]
    assert [service.serves_group(key) for key in listener.adopted] == [True, False]
    await machine.leave()


async def test_adopted_container_without_hello_is_replaced(store: MemoryStore, tmp_path: Path) -> None:
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


async def test_robots_wait_briefly_for_machines_that_may_return(
    service: MasterDriver, store: MemoryStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.control.master_driver.RETURN_TIMEOUT", 0.1)
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
    assert await second.welcome == control_link.Welcome("this"), "its robot is served elsewhere now"
    await first.leave()
    await second.leave()


async def test_containers_of_a_machine_lost_by_this_cloud_are_not_adopted(
    service: MasterDriver, store: MemoryStore, tmp_path: Path
) -> None:
    keep(store, running(), "this")
    machine = await FakeMachine.join(tmp_path, carries=(running(),))
    assert await machine.welcome == control_link.Welcome("this")
    assert at_once(service.containers.views(None)) == []
    await machine.leave()


async def test_machine_of_another_release_is_dismissed_and_robots_continue(
    store: MemoryStore, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    service = MasterDriver(Master(FirstFit()), CheckpointSelection(store, "this", math.inf), tmp_path, "secret")
    await service.start()
    service.of_machines.expect_back(["m1"])
    keep(store, running())
    old = await FakeMachine.join(tmp_path, carries=(running(),), release="0.0.9")
    assert await old.order() is None and old.dismissed, "so that it ends all its containers"
    assert "'m1' runs release 0.0.9 with unknown protocols" in caplog.text
    service.open_place(robot_request())
    new = await FakeMachine.join(tmp_path)
    order = await new.started()
    assert order.spec.robot == robot_request().robot and order.spec.checkpoint
    await new.leave()
    await service.close()


async def test_container_that_disconnects_but_runs_is_replaced(service: MasterDriver, tmp_path: Path) -> None:
    machine = await FakeMachine.join(tmp_path)
    service.open_place(robot_request())
    container = await machine.boot(await machine.started())
    await until(lambda: at_once(service.containers.views(None))[0].state == "ready")
    await container.stream.close()
    assert await machine.stopped() == container.spec.id
    await machine.leave()


async def test_registration_is_refused_while_the_store_is_unavailable(
    service: MasterDriver, store: MemoryStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away(*_: object) -> None:
        raise Unavailable("the store is away")

    with monkeypatch.context() as patched:
        patched.setattr(store, "clone", away)
        machine = await FakeMachine.join(tmp_path, carries=(running(),))
        assert await machine.order() is None and not machine.dismissed, (
            "so that it keeps its containers and tries again"
        )
    keep(store, running())
    again = await FakeMachine.join(tmp_path, carries=(running(),))
    assert (await again.welcome).adopted == ("old",)
    await again.leave()
    await machine.leave()


async def test_listener_is_notified_of_joining_and_leaving_machines(
    service: MasterDriver, tmp_path: Path, listener: RememberingListener
) -> None:
    machine = await FakeMachine.join(tmp_path)
    await until(lambda: listener.machines == [["m1"]])
    await machine.leave()
    await until(lambda: listener.machines == [["m1"], []])


def test_container_specs_round_trip() -> None:
    """Otherwise a repeated request would look like one for another robot."""
    container = running()
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(container), type=control_link.RunningContainer) == container


async def test_places_know_the_frame_of_the_base_whether_opened_or_adopted(
    service: MasterDriver, store: MemoryStore, tmp_path: Path
) -> None:
    parameters = {"amcl": {"base_frame_id": "chassis"}}
    assert service.open_place(robot_request("tb2", parameters=parameters)).base_frame == "chassis"
    carried = running()
    assert carried.spec.robot is not None
    robot = msgspec.structs.replace(carried.spec.robot, parameters=parameters)
    carried = msgspec.structs.replace(carried, spec=msgspec.structs.replace(carried.spec, robot=robot))
    keep(store, carried)
    machine = await FakeMachine.join(tmp_path, carries=(carried,))
    await until(lambda: service.place("robot:ann/tb1") is not None)
    place = service.place("robot:ann/tb1")
    assert place is not None and place.base_frame == "chassis"
    await machine.leave()
