"""Tests of the master's driver, with machines and containers simulated by the test."""

import asyncio
import threading
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from engine.control.master_calls.cloud import MapsInUse
from engine.control.master_driver import MasterDriver
from engine.control.views import LifelongRobot, MappingRobot
from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.master.places import CRASH_LIMIT
from engine.master.quotas import Quota, Quotas
from engine.protocols import control_link, robot_link
from engine.protocols.refusals import Refusal
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import SESSION_STATE, MapVersion
from ppaas.errors import Conflict, NotFound, QuotaExceeded, Unavailable
from storage.memory.store import MemoryStore
from storage.records import CloneCheckpoint
from tests.support.engine.at_once import at_once
from tests.support.engine.engine_links import dial_link, receive
from tests.support.engine.fake_machine import FakeMachine, FarContainer
from tests.support.engine.listening import Listening
from tests.support.engine.specs import HOUSE, robot_request
from tests.support.waiting import until


class SlowStore(MemoryStore):
    """Store that delays reading or removing a checkpoint on request, and can be unreachable."""

    def __init__(self) -> None:
        super().__init__()
        self.go = threading.Event()
        self.go.set()
        self.errors: list[Exception] = []

    def _wait(self) -> None:
        assert self.go.wait(10)
        if self.errors:
            raise self.errors.pop()

    def clone(self, user: str, robot: str) -> CloneCheckpoint:
        self._wait()
        return super().clone(user, robot)

    def remove_clone(self, user: str, robot: str) -> None:
        self._wait()
        super().remove_clone(user, robot)


@pytest.fixture
def store() -> SlowStore:
    return SlowStore()


@pytest.fixture
async def service(tmp_path: Path, store: SlowStore) -> AsyncIterator[MasterDriver]:
    master = Master(FirstFit(), Quotas(Quota(containers=8, cores=8.0)))
    opened = MasterDriver(master, CheckpointSelection(store), tmp_path, "secret")
    await opened.start()
    yield opened
    store.go.set()
    await opened.close()
    assert_forgotten(opened)


@pytest.fixture
async def machine(service: MasterDriver, tmp_path: Path) -> AsyncIterator[FakeMachine]:
    joined = await FakeMachine.join(tmp_path)
    await service.wait_for_machine(10)
    yield joined
    await joined.leave()


def assert_forgotten(service: MasterDriver) -> None:
    """Check that no place or container is left."""
    assert len(service._times) == 0
    assert service._links.awaited == 0
    assert service._places == {}
    assert service._master.places == {}
    assert service._master._state.place_of == {}


def checkpoint(session: str, **nodes: bytes) -> CloneCheckpoint:
    return CloneCheckpoint("ann", "tb1", {SESSION_STATE: session.encode(), **nodes}, 1.0)


# -- machines ----------------------------------------------------------------------------------------------------------


async def test_cloud_without_machines_raises_unavailable(service: MasterDriver) -> None:
    with pytest.raises(Unavailable, match="no machine"):
        await service.wait_for_machine(0.01)


async def test_machines_are_listed_with_their_load(service: MasterDriver, machine: FakeMachine) -> None:
    machine.tell(control_link.Heartbeat(0.5, 1 << 20, [control_link.ContainerLoad("c1", 0.25, 1 << 10)]))
    await until(lambda: at_once(service.administration.views())[0].load)
    (view,) = at_once(service.administration.views())
    assert (view.id, view.cores, view.load, view.memory_used) == ("m1", 2, 0.5, 1 << 20)


async def test_places_of_a_lost_machine_are_filled_by_the_next(
    service: MasterDriver, machine: FakeMachine, tmp_path: Path
) -> None:
    place, client = service.open_place(robot_request()), Listening()
    number = place.join(client)
    first = await machine.boot(await machine.started())
    await place.ready(10)
    place.deliver("goal", b"1", number, must_arrive=True)
    starting = service.open_place(robot_request("tb2"))
    await machine.started()
    await machine.leave()
    await first.stream.close()
    await until(lambda: not at_once(service.administration.views()))
    assert (service.counts.machines_lost, sum(service.counts.placements.counts)) == (1, 1)
    assert len(service._times) == 0
    assert service._links.awaited == 0
    second = await FakeMachine.join(tmp_path, "m2")
    containers = [await second.boot(await second.started()) for _ in range(2)]
    await place.ready(10)
    await starting.ready(10)
    resent = await containers[0].next()
    assert isinstance(resent, robot_link.Deliver) and resent.payload == b"1"
    assert client.reasons == []
    await second.leave()


# -- a place from its opening to its close -----------------------------------------------------------------------------


async def test_place_is_filled_listed_and_closed(service: MasterDriver, machine: FakeMachine) -> None:
    place, client = service.open_place(robot_request(cores=0.5)), Listening()
    place.join(client)
    assert service.open_place(robot_request(cores=0.5)) is place is service.place(place.key)
    order = await machine.started()
    assert (order.spec.user, order.spec.map, order.spec.cores, order.spec.checkpoint) == ("ann", HOUSE, 0.5, {})
    assert [view.state for view in at_once(service.containers.views("ann"))] == ["starting"]
    container = await machine.boot(order)
    await place.ready(10)
    (view,) = at_once(service.containers.views("ann"))
    assert (view.id, view.state, view.pid, view.machine, view.robot) == (order.spec.id, "ready", 42, "m1", "tb1")
    assert view.ready_seconds is not None and view.ready_seconds > 0.0
    assert (view.clients, view.cpu) == (1, None) and view.age >= view.ready_seconds
    assert service.counts.placements.total == view.ready_seconds
    machine.tell(control_link.Heartbeat(0.5, 1 << 20, [control_link.ContainerLoad(view.id, 0.25, 1 << 10)]))
    await until(lambda: at_once(service.containers.views("ann"))[0].cpu == 0.25)
    assert at_once(service.containers.views("ann"))[0].pss == 1 << 10
    assert at_once(service.containers.views("bob")) == []
    await service.close_place(place.key, Unavailable("over"))
    assert await container.next() == robot_link.Shutdown()
    assert await machine.stopped() == order.spec.id
    assert [str(reason) for reason in client.reasons] == ["over"]
    await machine.kill(container, 0)
    assert_forgotten(service)
    assert service.counts.containers_lost == 0, "it was ended"


async def test_changed_request_for_an_open_place_conflicts(service: MasterDriver, machine: FakeMachine) -> None:
    service.open_place(robot_request())
    with pytest.raises(Conflict):
        service.open_place(robot_request(cores=2.0))


async def test_refused_place_leaves_no_state(service: MasterDriver, machine: FakeMachine) -> None:
    with pytest.raises(QuotaExceeded):
        service.open_place(robot_request(cores=3.0))
    assert_forgotten(service)


async def test_lost_container_is_replaced_and_the_link_continues(
    service: MasterDriver, machine: FakeMachine, store: SlowStore
) -> None:
    place, client = service.open_place(robot_request()), Listening()
    number = place.join(client)
    first = await machine.boot(await machine.started())
    await place.ready(10)
    place.subscribe("map", number)
    for goal in (b"1", b"2"):
        place.deliver("goal", goal, number, must_arrive=True)
    assert [type(await first.next()) for _ in range(3)] == [
        robot_link.SubscribeTopic,
        robot_link.Deliver,
        robot_link.Deliver,
    ]
    store.save_clone(checkpoint(first.spec.id, link=b"1", amcl=b"{}"))
    await machine.kill(first)
    order = await machine.started()
    assert order.spec.id != first.spec.id
    assert order.spec.checkpoint == {SESSION_STATE: first.spec.id.encode(), "link": b"1", "amcl": b"{}"}
    second = await machine.boot(order, pid=43, applied=1)
    frames = [await second.next() for _ in range(2)]
    assert frames == [robot_link.SubscribeTopic("map", 0), robot_link.Deliver("goal", b"2", number, 2)]
    assert (place.container, place.pid) == (order.spec.id, 43)
    second.stream.write(robot_link.Published("map", b"{}"))
    await until(lambda: client.heard)
    assert client.reasons == []
    assert service.counts.containers_lost == 1
    await machine.kill(second)


async def test_new_session_does_not_use_an_older_checkpoint(
    service: MasterDriver, machine: FakeMachine, store: SlowStore
) -> None:
    place = service.open_place(robot_request())
    first = await machine.started()
    await service.close_place(place.key, Unavailable("over"))
    await machine.stopped()
    store.save_clone(checkpoint(first.spec.id, link=b"50"))
    service.open_place(robot_request())
    second = await machine.started()
    assert second.spec.checkpoint == {}
    with pytest.raises(NotFound):
        store.clone("ann", "tb1")
    # The last container of the first session ends late, and its last checkpoint comes after the second has begun.
    store.save_clone(checkpoint(first.spec.id, link=b"51"))
    machine.tell(control_link.Exited(second.spec.id, -9))
    third = await machine.started()
    assert third.spec.checkpoint == {}


async def test_container_that_does_not_start_is_stopped_and_replaced(
    tmp_path: Path, store: SlowStore, caplog: pytest.LogCaptureFixture
) -> None:
    service = MasterDriver(Master(FirstFit()), CheckpointSelection(store), tmp_path, "secret", start_timeout=0.05)
    await service.start()
    machine = await FakeMachine.join(tmp_path)
    await service.wait_for_machine(10)
    service.open_place(robot_request())
    late = await machine.started()
    assert await machine.stopped() == late.spec.id
    order = await machine.started()
    assert order.spec.id != late.spec.id
    assert "did not answer within 0.05 s" in caplog.text
    stream = (await machine.boot(late)).stream  # too late
    assert await receive(stream) is None
    await service.close()
    assert_forgotten(service)
    await machine.leave()


async def test_ready_container_is_not_stopped_by_the_start_timeout(tmp_path: Path, store: SlowStore) -> None:
    service = MasterDriver(Master(FirstFit()), CheckpointSelection(store), tmp_path, "secret", start_timeout=0.2)
    await service.start()
    machine = await FakeMachine.join(tmp_path)
    await service.wait_for_machine(10)
    place = service.open_place(robot_request())
    container = await machine.boot(await machine.started())
    await place.ready(10)
    await until(lambda: not service._background._tasks)
    assert not machine.has_orders()
    assert place.container == container.spec.id
    await service.close()
    assert_forgotten(service)
    await machine.leave()


@pytest.mark.parametrize("reported_by", ["machine", "container"])
async def test_container_that_can_never_start_closes_its_place(
    service: MasterDriver, machine: FakeMachine, reported_by: str
) -> None:
    place, client = service.open_place(robot_request()), Listening()
    place.join(client)
    order = await machine.started()
    error = NotFound("model", "toaster", ["turtlebot2"])
    refusal = Refusal(error.slug, str(error))
    if reported_by == "machine":
        machine.tell(control_link.LaunchFailed(order.spec.id, refusal))
    else:
        (await dial_link(order.link)).write(robot_link.ContainerFailed(order.spec.id, order.secret, refusal))
    with pytest.raises(NotFound, match="known: turtlebot2"):
        await place.ready(10)
    assert [type(reason) for reason in client.reasons] == [NotFound]
    assert_forgotten(service)
    assert not machine.has_orders()


async def test_crash_loop_closes_the_place_with_the_reason(
    service: MasterDriver, machine: FakeMachine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.master.places.RESTART_DELAYS", (0.0,) * CRASH_LIMIT)
    place = service.open_place(robot_request())
    for _ in range(CRASH_LIMIT + 1):
        order = await machine.started()
        machine.tell(control_link.LaunchFailed(order.spec.id, Refusal("unavailable", "no room in shared memory")))
    with pytest.raises(Unavailable, match="no room in shared memory"):
        await place.ready(10)
    assert_forgotten(service)


@pytest.mark.parametrize("error", [Unavailable("the disk is away"), OSError(5)], ids=["known", "unknown"])
async def test_brief_store_outage_delays_the_start(
    service: MasterDriver, machine: FakeMachine, store: SlowStore, error: Exception
) -> None:
    store.errors.append(error)
    place = service.open_place(robot_request())
    assert isinstance(
        await machine.order(), control_link.StopContainer
    )  # it was never started; stopping it has no effect
    await machine.boot(await machine.started())
    await place.ready(10)


# -- a place that is closed while it starts ----------------------------------------------------------------------------


async def test_place_closed_before_its_order_starts_nothing(
    service: MasterDriver, machine: FakeMachine, store: SlowStore
) -> None:
    place = service.open_place(robot_request())
    await service.close_place(place.key, Unavailable("over"))
    await until(lambda: not service._background._tasks)
    assert isinstance(await machine.order(), control_link.StopContainer)
    assert not machine.has_orders()
    assert_forgotten(service)


async def test_place_closed_during_checkpoint_read_starts_nothing(
    service: MasterDriver, machine: FakeMachine, store: SlowStore
) -> None:
    store.go.clear()
    place = service.open_place(robot_request())
    await asyncio.sleep(0)
    await service.close_place(place.key, Unavailable("over"))
    store.go.set()
    await until(lambda: not service._background._tasks)
    assert isinstance(await machine.order(), control_link.StopContainer)
    assert not machine.has_orders()
    assert_forgotten(service)


async def test_machine_lost_during_checkpoint_read_is_sent_nothing(
    service: MasterDriver, machine: FakeMachine, store: SlowStore
) -> None:
    store.go.clear()
    place = service.open_place(robot_request())
    await asyncio.sleep(0)
    await machine.leave()
    await until(lambda: not at_once(service.administration.views()))
    store.go.set()
    await until(lambda: not service._background._tasks)
    assert len(service._times) == 0
    assert service._links.awaited == 0
    await service.close_place(place.key, Unavailable("over"))
    assert_forgotten(service)


async def test_place_closed_while_its_container_boots_stops_it(service: MasterDriver, machine: FakeMachine) -> None:
    place = service.open_place(robot_request())
    order = await machine.started()
    await service.close_place(place.key, Unavailable("over"))
    container = await machine.boot(order)
    assert await container.next() is None
    assert await machine.stopped() == order.spec.id
    await machine.kill(container)
    assert_forgotten(service)
    assert not machine.has_orders()


async def test_given_up_container_is_replaced(service: MasterDriver, machine: FakeMachine) -> None:
    place, client = service.open_place(robot_request()), Listening()
    place.join(client)
    first = await machine.boot(await machine.started())
    await place.ready(10)
    await service.containers.give_up(first.spec.id)
    assert await machine.order() == control_link.StopContainer(first.spec.id, grace=0.0)
    await machine.kill(first)
    second = await machine.boot(await machine.started())
    await until(lambda: [view.state for view in at_once(service.containers.views("ann"))] == ["ready"])
    assert (second.spec.session, client.reasons) == (first.spec.session, [])
    with pytest.raises(NotFound, match=first.spec.id):
        await service.containers.give_up(first.spec.id)


async def test_robots_that_make_new_maps_are_listed_once_their_containers_run(
    service: MasterDriver, machine: FakeMachine
) -> None:
    new = MapVersion("new:office-2", "")
    own = service.open_place(robot_request("tb1", version=new, new_map="office-2"))
    lifelong = {"grid_slam": {"mode": "lifelong"}}
    service.open_place(robot_request("tb2", version=new, new_map="office-2", continued=HOUSE, parameters=lifelong))
    service.open_place(robot_request("tb3"))
    maps = MapsInUse(service, ())
    assert await maps.mapping_robots() == await maps.lifelong_robots() == []
    containers = [await machine.boot(await machine.started()) for _ in range(3)]
    await own.ready(10)
    await until(lambda: len([view for view in at_once(service.containers.views("ann")) if view.state == "ready"]) == 3)
    assert await maps.mapping_robots() == [MappingRobot("ann", "tb1", "new:office-2@ann")]
    assert await maps.lifelong_robots() == [LifelongRobot("ann", "tb2", "house")]
    await containers[0].stream.close()


async def test_reports_about_unknown_containers_change_nothing(service: MasterDriver, machine: FakeMachine) -> None:
    service.open_place(robot_request())
    order = await machine.started()
    for event in (
        control_link.Exited("c99", 0),
        control_link.Launched("c99", 1),
        control_link.LaunchFailed("c99", Refusal("not-found", "")),
        control_link.Launched(order.spec.id, 77),
    ):
        machine.tell(event)
    await until(lambda: at_once(service.containers.views(None))[0].pid == 77)
    assert not machine.has_orders()


async def test_closing_closes_all_places_and_dismisses_all_machines(
    service: MasterDriver, machine: FakeMachine, tmp_path: Path
) -> None:
    places, clients = [service.open_place(robot_request(f"tb{n}")) for n in range(2)], [Listening(), Listening()]
    for place, client in zip(places, clients, strict=True):
        place.join(client)
    ready: FarContainer = await machine.boot(await machine.started())
    await places[0].ready(10)
    await machine.started()
    await service.close()
    assert_forgotten(service)
    assert [str(client.reasons[0]) for client in clients] == ["the cloud is shutting down"] * 2
    assert await ready.next() == robot_link.Shutdown()
    assert await ready.next() is None
    assert [type(await machine.order()) for _ in range(3)] == [
        control_link.StopContainer,
        control_link.StopContainer,
        type(None),
    ]
    for name in ("link.sock", "control.sock"):
        with pytest.raises(OSError):
            await dial_link(tmp_path / name)
