"""Tests of robot sessions: clients of places, and when a place is closed."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from engine.control.master_driver import MasterDriver
from engine.control.robot_sessions import RobotSessions
from engine.links.place_link import PlaceLink
from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.master.quotas import Quota, Quotas
from engine.protocols import robot_link
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import MapVersion, RobotConfig
from ppaas.errors import Conflict, Idle, InvalidParameter, NotFound, NotPermitted, QuotaExceeded, Unavailable
from ppaas.nodes.follow_path.node import RobotPathFollower
from ppaas.nodes.tf.urdf_text import UrdfText
from ppaas.robot_model.describe import describe
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.records import RobotRecord
from tests.support.engine.specs import robot_request
from tests.support.storage import records
from tests.support.waiting import until
from tests.support.world.urdf import example

PATHS: dict[str, Any] = {RobotPathFollower.name: {}}
LONG = 1000.0
SHORT = 0.02


@pytest.fixture
async def service(tmp_path: Path) -> AsyncIterator[MasterDriver]:
    """Return a cloud without machines; its places wait for one."""
    master = Master(FirstFit(), Quotas(Quota(containers=2)))
    opened = MasterDriver(master, CheckpointSelection(MemoryStore()), tmp_path, "secret")
    await opened.start()
    yield opened
    await opened.close()


@pytest.fixture
def map_store() -> MemoryMapStore:
    store = MemoryMapStore()
    records.put_map(store, records.house())
    return store


@pytest.fixture
def store() -> MemoryStore:
    store = MemoryStore()
    for name in ("tb1", "tb2", "tb3"):
        store.put_robot(records.robot(name, user="ann", map="house"))
    return store


@pytest.fixture
async def sessions(
    service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore
) -> AsyncIterator[RobotSessions]:
    made = RobotSessions(service, store, map_store, LONG)
    yield made
    await made.close()


def is_open(service: MasterDriver, place: PlaceLink) -> bool:
    return service.place(place.key) is place


async def test_robot_and_its_operators_share_a_place(service: MasterDriver, sessions: RobotSessions) -> None:
    robot = await sessions.join("ann", "tb1", as_robot=True)
    operators = [await sessions.join("ann", "tb1", as_robot=False) for _ in range(2)]
    other = await sessions.join("ann", "tb2", as_robot=True)
    assert operators == [robot, robot]
    assert other is not robot


async def test_place_has_the_stored_robot_and_map(service: MasterDriver, sessions: RobotSessions) -> None:
    place = await sessions.join("ann", "tb1", as_robot=True)
    request = service._master.places[place.key].request
    assert request.robot is not None
    assert (request.user, request.robot.id, request.robot.model) == ("ann", "tb1", "turtlebot2")
    assert (request.map.id, request.map.version) == ("house", records.house().version)


@pytest.mark.parametrize(
    ("given", "expected"),
    [({}, {"traffic": {}}), ({"traffic": {"reaction": 0.3}}, {"traffic": {"reaction": 0.3}}), (PATHS, PATHS)],
)
async def test_robots_on_a_map_with_traffic_take_part_unless_they_follow_paths_themselves(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore,
    given: dict[str, Any], expected: dict[str, Any],
) -> None:  # fmt: skip
    map_store.change_map("house", traffic=True)
    store.put_robot(msgspec.structs.replace(store.robot("ann", "tb1"), parameters=given))
    place = await sessions.join("ann", "tb1", as_robot=True)
    robot = service._master.places[place.key].request.robot
    assert robot is not None and robot.parameters == expected


@pytest.fixture
def upstairs(map_store: MemoryMapStore) -> str:
    """Return the id of another map, on which robots take part in the traffic."""
    records.put_map(map_store, records.house("house-2"))
    map_store.change_map("house-2", traffic=True)
    return "house-2"


async def test_the_place_of_a_robot_that_was_brought_to_another_map_goes_on_there(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, upstairs: str
) -> None:
    await sessions.moved("ann", "tb1")
    place = await sessions.join("ann", "tb1", as_robot=True)
    record = store.robot("ann", "tb1")
    store.put_robot(
        msgspec.structs.replace(record, map=upstairs, initial_pose=(1.0, 2.0, 0.5), model="turtlebot3_burger")
    )
    await sessions.moved("ann", "tb1")
    request = service._master.places[place.key].request
    assert request.robot is not None and is_open(service, place)
    assert (request.map.id, request.robot.initial_pose) == (upstairs, (1.0, 2.0, 0.5))
    assert (request.robot.parameters, request.robot.model) == ({"traffic": {}}, "turtlebot2"), (
        "the rest when it returns"
    )


async def test_a_robot_that_returns_with_another_map_in_its_file_keeps_its_place(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, upstairs: str
) -> None:
    place = await sessions.join("ann", "tb1", as_robot=True)
    sessions.leave(place.key, as_robot=True)
    store.put_robot(msgspec.structs.replace(store.robot("ann", "tb1"), map=upstairs, initial_pose=(1.0, 2.0, 0.5)))
    assert await sessions.join("ann", "tb1", as_robot=True) is place
    assert service._master.places[place.key].request.map.id == upstairs


async def test_a_second_robot_is_refused_until_the_first_has_left(sessions: RobotSessions) -> None:
    first = await sessions.join("ann", "tb1", as_robot=True)
    with pytest.raises(Conflict, match="connected already"):
        await sessions.join("ann", "tb1", as_robot=True)
    sessions.leave(first.key, as_robot=True)
    assert await sessions.join("ann", "tb1", as_robot=True) is first


async def test_only_one_of_several_concurrent_robots_joins(sessions: RobotSessions) -> None:
    joins = [sessions.join("ann", "tb1", as_robot=True) for _ in range(5)]
    results = await asyncio.gather(*joins, return_exceptions=True)
    assert sorted(type(result).__name__ for result in results) == ["Conflict"] * 4 + ["PlaceLink"]


@pytest.mark.parametrize("robot_leaves_first", [True, False])
async def test_place_closes_after_its_last_client_left(
    service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore, robot_leaves_first: bool
) -> None:
    sessions = RobotSessions(service, store, map_store, SHORT)
    place = await sessions.join("ann", "tb1", as_robot=True)
    await sessions.join("ann", "tb1", as_robot=False)
    sessions.leave(place.key, as_robot=robot_leaves_first)
    await asyncio.sleep(3 * SHORT)
    assert is_open(service, place)
    sessions.leave(place.key, as_robot=not robot_leaves_first)
    await until(lambda: not is_open(service, place))
    with pytest.raises(Unavailable, match="no client was connected"):
        await place.ready(1)


async def test_client_that_returns_in_time_keeps_the_place(
    service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    sessions = RobotSessions(service, store, map_store, SHORT)
    place = await sessions.join("ann", "tb1", as_robot=True)
    sessions.leave(place.key, as_robot=True)
    assert await sessions.join("ann", "tb1", as_robot=True) is place
    await asyncio.sleep(3 * SHORT)
    assert is_open(service, place)


async def test_client_that_returns_too_late_gets_a_new_place(
    service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    sessions = RobotSessions(service, store, map_store, 0.0)
    place = await sessions.join("ann", "tb1", as_robot=True)
    sessions.leave(place.key, as_robot=True)
    await until(lambda: not is_open(service, place))
    new_place = await sessions.join("ann", "tb1", as_robot=True)
    assert new_place is not place
    assert is_open(service, new_place)


async def test_robot_that_returns_keeps_its_place_on_the_new_version_of_its_map(
    service: MasterDriver, sessions: RobotSessions, map_store: MemoryMapStore
) -> None:
    place = await sessions.join("ann", "tb1", as_robot=True)
    head = records.put_map(map_store, records.house(image=records.pgm(value=205)))
    sessions.leave(place.key, as_robot=True)
    assert await sessions.join("ann", "tb1", as_robot=True) is place
    request = service.request_of(place.key)
    assert request is not None
    assert request.map.version == head.version
    sessions.leave(place.key, as_robot=True)


def change_file(store: MemoryStore, map_store: MemoryMapStore) -> None:
    store.put_robot(records.robot("tb1", user="ann", map="house", model="turtlebot3_burger"))


def change_map(store: MemoryStore, map_store: MemoryMapStore) -> None:
    records.put_map(map_store, records.house(image=records.pgm(value=205)))


def name_a_map_that_does_not_exist(store: MemoryStore, map_store: MemoryMapStore) -> None:
    store.put_robot(records.robot("tb1", user="ann", map="nowhere"))


def name_a_mask_that_does_not_exist(store: MemoryStore, map_store: MemoryMapStore) -> None:
    store.put_robot(records.robot("tb1", user="ann", map="house", parameters=MASKED))


@pytest.mark.parametrize("hold", [True, False])
@pytest.mark.parametrize(
    "change", [change_file, change_map, name_a_map_that_does_not_exist, name_a_mask_that_does_not_exist]
)
async def test_operator_joins_the_robot_that_drives_whatever_was_changed_since(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore, change, hold: bool
) -> None:
    place = await sessions.join("ann", "tb1", as_robot=True)
    change(store, map_store)
    assert await sessions.join("ann", "tb1", as_robot=False, hold=hold) is place
    assert is_open(service, place)


async def test_operator_joins_a_lingering_place_with_earlier_settings(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    place = await sessions.join("ann", "tb1", as_robot=True)
    sessions.leave(place.key, as_robot=True)
    change_file(store, map_store)
    assert await sessions.join("ann", "tb1", as_robot=False) is place


async def test_robot_gets_a_place_with_the_changes_although_operators_are_connected(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    place = await sessions.join("ann", "tb1", as_robot=True)
    await sessions.join("ann", "tb1", as_robot=False)
    sessions.leave(place.key, as_robot=True)
    change_file(store, map_store)
    joins = [sessions.join("ann", "tb1", as_robot=True) for _ in range(3)]
    results = await asyncio.gather(*joins, return_exceptions=True)
    [new_place] = [result for result in results if isinstance(result, PlaceLink)]
    assert new_place is not place and is_open(service, new_place)
    with pytest.raises(Unavailable, match="its robot or map was changed"):
        await place.ready(1)
    sessions.leave(place.key, as_robot=False)  # the operator, whose socket was closed
    assert sessions._clients == {"robot:ann/tb1": 1}


@pytest.mark.parametrize("hold", [True, False])
async def test_operator_needs_the_right_to_read_the_map_also_at_an_open_place(
    sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore, hold: bool
) -> None:
    await sessions.join("ann", "tb1", as_robot=True)
    records.put_map(map_store, records.house("vault", "bob", readers=("eve",)))
    store.put_robot(records.robot("tb1", user="ann", map="vault"))
    with pytest.raises(NotPermitted):
        await sessions.join("ann", "tb1", as_robot=False, hold=hold)
    store.remove_robot("ann", "tb1")
    with pytest.raises(NotFound):
        await sessions.join("ann", "tb1", as_robot=False, hold=hold)


MASKED = {"keepout_filter": {"filter_mask": "kept"}, "speed_filter": {"filter_mask": "slow", "enabled": False}}


async def test_place_has_the_mask_versions_of_its_opening(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    store.put_robot(records.robot("tb1", user="ann", map="house", parameters=MASKED))
    for value in (205, 0):
        records.put_map(map_store, records.house("kept", image=records.pgm(value=value)))
        place = await sessions.join("ann", "tb1", as_robot=True)
        request = service._master.places[place.key].request
        assert request.robot is not None
        present = map_store.map_head("kept").version
        assert request.robot.masks == {"keepout_filter": MapVersion("kept", present)}
        sessions.leave(place.key, as_robot=True)


async def test_place_states_whether_its_map_has_an_octomap(
    service: MasterDriver, sessions: RobotSessions, map_store: MemoryMapStore
) -> None:
    for octomap in (None, b"..."):
        records.put_map(map_store, records.house(octomap=octomap))
        place = await sessions.join("ann", "tb1", as_robot=True)
        request = service._master.places[place.key].request
        assert request.robot is not None
        assert request.robot.in_space == (octomap is not None)
        sessions.leave(place.key, as_robot=True)


@pytest.mark.parametrize("owner", ["ann", "bob"])
async def test_invalid_mask_refuses_the_robot_and_keeps_its_checkpoint(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore, owner: str
) -> None:
    store.put_robot(records.robot("tb1", user="ann", map="house", parameters=MASKED))
    store.save_clone(records.clone("tb1"))
    with pytest.raises(InvalidParameter, match="keepout_filter: the mask 'kept' is not a published map"):
        await sessions.join("ann", "tb1", as_robot=True)
    octomap = records.house("kept", owner, image=None, octomap=b"...")
    records.put_map(map_store, octomap)
    why = "has an octomap and no grid" if owner == "ann" else "is not a published map"
    with pytest.raises(InvalidParameter, match=why):
        await sessions.join("ann", "tb1", as_robot=True)
    assert (service._places, sessions._clients) == ({}, {})
    assert store.clone("ann", "tb1") == records.clone("tb1")
    records.put_map(map_store, records.house("kept", owner, readers=("ann",)))
    assert is_open(service, await sessions.join("ann", "tb1", as_robot=True))


async def test_refused_join_leaves_no_state(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    records.put_map(map_store, records.house("vault", "bob", readers=("eve",)))
    store.put_robot(records.robot("thief", user="ann", map="vault"))
    store.put_robot(records.robot("lost", user="ann", map="nowhere"))
    for name, error in (("thief", NotPermitted), ("lost", NotFound), ("nobody", NotFound)):
        with pytest.raises(error):
            await sessions.join("ann", name, as_robot=True)
    for name in ("tb1", "tb2"):
        await sessions.join("ann", name, as_robot=True)
    for _ in range(2):
        with pytest.raises(QuotaExceeded):
            await sessions.join("ann", "tb3", as_robot=True)
    assert sorted(service._places) == ["robot:ann/tb1", "robot:ann/tb2"]
    assert sessions._clients.keys() == service._places.keys()
    here = {key for key in ("robot:ann/tb1", "robot:ann/tb2", "robot:ann/tb3") if service.presence.is_here(key)}
    assert here == service._places.keys()


async def test_a_refused_robot_does_not_keep_a_lingering_place_alive(
    service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    sessions = RobotSessions(service, store, map_store, SHORT)
    place = await sessions.join("ann", "tb1", as_robot=True)
    sessions.leave(place.key, as_robot=True)
    store.remove_robot("ann", "tb1")
    with pytest.raises(NotFound):
        await sessions.join("ann", "tb1", as_robot=True)
    await until(lambda: not is_open(service, place))


async def test_leaving_a_closed_place_does_not_affect_the_next(service: MasterDriver, sessions: RobotSessions) -> None:
    old = await sessions.join("ann", "tb1", as_robot=True)
    await sessions.join("ann", "tb1", as_robot=False)
    await service.close_place(old.key, Unavailable("it crashed"))
    sessions.leave(old.key, as_robot=True)
    new = await sessions.join("ann", "tb1", as_robot=True)
    sessions.leave(old.key, as_robot=False)
    assert new is not old
    assert is_open(service, new)
    assert sessions._closing == {}


async def test_closing_cancels_lingering(service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore) -> None:
    sessions = RobotSessions(service, store, map_store, SHORT)
    place = await sessions.join("ann", "tb1", as_robot=True)
    sessions.leave(place.key, as_robot=True)
    await sessions.close()
    await asyncio.sleep(3 * SHORT)
    assert is_open(service, place)


async def test_join_without_hold_needs_an_open_place_and_does_not_keep_it(
    service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    sessions = RobotSessions(service, store, map_store, SHORT)
    with pytest.raises(Unavailable, match="no container now"):
        await sessions.join("ann", "tb1", as_robot=False, hold=False)
    place = await sessions.join("ann", "tb1", as_robot=True)
    assert await sessions.join("ann", "tb1", as_robot=False, hold=False) is place
    sessions.leave(place.key, as_robot=True)
    assert await sessions.join("ann", "tb1", as_robot=False, hold=False) is place, "the lingering place is open"
    await until(lambda: not is_open(service, place))


async def test_let_go_closes_the_place_although_clients_are_connected(
    service: MasterDriver, sessions: RobotSessions
) -> None:
    place = await sessions.join("ann", "tb1", as_robot=True)
    await sessions.let_go(place, Idle("nothing was said"))
    assert not is_open(service, place)
    sessions.leave(place.key, as_robot=True)
    new_place = await sessions.join("ann", "tb1", as_robot=True)
    await sessions.let_go(place, Idle("nothing was said"))
    assert is_open(service, new_place), "the place that was let go has been replaced"
    sessions.leave(new_place.key, as_robot=True)


async def test_place_has_the_description_of_the_robots_urdf(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore
) -> None:
    store.put_urdf("ann", "tb1", example("turtlebot3_waffle"))
    for robot, description in (("tb1", describe(example("turtlebot3_waffle"))), ("tb2", None)):
        place = await sessions.join("ann", robot, as_robot=True)
        request = service._master.places[place.key].request
        assert request.robot is not None
        assert request.robot.urdf == description
        stored = example("turtlebot3_waffle") if robot == "tb1" else None
        assert request.robot.urdf_text == (UrdfText.of(stored).compressed if stored else b"")
        assert msgspec.msgpack.decode(msgspec.msgpack.encode(request.robot), type=RobotConfig) == request.robot


async def test_place_requires_the_labels_of_the_robots_file(
    sessions: RobotSessions, service: MasterDriver, store: MemoryStore
) -> None:
    store.put_robot(records.robot("tb1", user="ann", map="house", labels={"zone": "a"}))
    place = await sessions.join("ann", "tb1", as_robot=True)
    assert service._master.places[place.key].request.labels == {"zone": "a"}


async def test_place_has_the_clouds_node_monitor_priorities(
    service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    sessions = RobotSessions(service, store, map_store, LONG, node_priorities=("network_bandwidth",))
    place = await sessions.join("ann", "tb1", as_robot=True)
    request = service._master.places[place.key].request
    assert request.robot is not None
    assert request.robot.parameters["node_monitor"] == {"priorities": ["network_bandwidth"]}
    await sessions.close()


async def test_adopted_place_lingers_until_its_robot_joins(
    service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    sessions = RobotSessions(service, store, map_store, SHORT)
    place = await sessions.join("ann", "tb1", as_robot=True)
    sessions.await_back(place.key)
    await asyncio.sleep(2 * SHORT)
    assert is_open(service, place), "its robot is connected"
    adopted = service.open_place(robot_request("tb2"))
    sessions.await_back(adopted.key)
    await until(lambda: not is_open(service, adopted))
    await sessions.close()


async def test_the_robot_is_present_with_its_own_socket_and_not_with_its_place(
    service: MasterDriver, sessions: RobotSessions
) -> None:
    operated = await sessions.join("ann", "tb1", as_robot=False)
    assert not service.presence.is_here(operated.key)
    place = await sessions.join("ann", "tb1", as_robot=True)
    assert service.presence.is_here(place.key)
    sessions.leave(place.key, as_robot=True)
    assert is_open(service, place)
    assert not service.presence.is_here(place.key)
    await sessions.join("ann", "tb1", as_robot=True)
    assert service.presence.is_here(place.key)


async def test_a_robot_that_was_refused_is_not_present(service: MasterDriver, sessions: RobotSessions) -> None:
    for robot in ("tb1", "tb2"):
        await sessions.join("ann", robot, as_robot=True)
    with pytest.raises(QuotaExceeded):
        await sessions.join("ann", "tb3", as_robot=True)
    assert not service.presence.is_here("robot:ann/tb3")


async def test_the_robot_of_an_adopted_place_is_present_by_its_container_until_the_place_is_given_up(
    service: MasterDriver, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    sessions = RobotSessions(service, store, map_store, SHORT)
    adopted = service.open_place(robot_request("tb1"))
    sessions.await_back(adopted.key)
    adopted.take(robot_link.ContainerBeat(busy=False, sockets=1, robot=True))
    assert service.presence.is_here(adopted.key)
    await until(lambda: not is_open(service, adopted))
    assert service.presence.of(adopted.key).disconnected_since is not None
    await sessions.close()


async def test_a_robot_that_makes_a_map_needs_none(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore
) -> None:
    store.put_robot(records.robot("tb1", user="ann", map="new:office-2"))
    place = await sessions.join("ann", "tb1", as_robot=True)
    request = service._master.places[place.key].request
    assert request.robot is not None
    assert (request.map, request.robot.new_map) == (MapVersion("new:office-2", ""), "office-2")
    assert await sessions.join("ann", "tb1", as_robot=False) is place
    assert sessions.map_ids(place) == (), "no published map whose readers are to be watched"


async def test_a_robot_gets_another_place_after_its_new_map_is_published(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore
) -> None:
    places = []
    for name in ("new:house", "house", "new:house"):
        store.put_robot(records.robot("tb1", user="ann", map=name))
        place = await sessions.join("ann", "tb1", as_robot=True)
        sessions.leave(place.key, as_robot=True)
        places.append((place, service._master.places[place.key].request.map.id))
    assert [name for _, name in places] == ["new:house", "house", "new:house"]
    assert len({id(place) for place, _ in places}) == 3


async def test_a_robot_keeps_its_place_although_the_map_that_it_continues_is_published_again(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    begun = records.put_map(map_store, records.house("office", posegraph=b"graph"))
    records.put_map(map_store, records.house("other", posegraph=b"graph"))
    store.put_robot(continuing("office"))
    place = await sessions.join("ann", "tb1", as_robot=True)
    records.put_map(map_store, records.house("office", posegraph=b"grown"))
    sessions.leave(place.key, as_robot=True)
    assert await sessions.join("ann", "tb1", as_robot=True) is place
    request = service.request_of(place.key)
    assert request is not None and request.robot is not None
    assert request.robot.continued == MapVersion("office", begun.version)
    sessions.leave(place.key, as_robot=True)
    store.put_robot(continuing("other"))
    assert await sessions.join("ann", "tb1", as_robot=True) is not place


async def test_a_robot_keeps_its_place_although_others_may_join_its_new_map_by_now(
    service: MasterDriver, sessions: RobotSessions, store: MemoryStore, map_store: MemoryMapStore
) -> None:
    store.put_robot(records.robot("tb1", user="bob", map="new:office-2"))
    place = await sessions.join("bob", "tb1", as_robot=True)
    records.put_map(map_store, records.house("office-2", readers=("bob",)))
    sessions.leave(place.key, as_robot=True)
    assert await sessions.join("bob", "tb1", as_robot=True) is place
    request = service.request_of(place.key)
    assert request is not None and request.robot is not None
    assert request.robot.map_owner == "bob"
    sessions.leave(place.key, as_robot=True)
    await service.close_place(place.key, Unavailable("gone"))
    place = await sessions.join("bob", "tb1", as_robot=True)
    request = service.request_of(place.key)
    assert request is not None and request.robot is not None
    assert request.robot.map_owner == "ann"


def continuing(map_id: str) -> RobotRecord:
    """Return a robot that continues a map."""
    return records.robot("tb1", user="ann", map="new:office-2", parameters={"grid_slam": {"map_file_name": map_id}})


async def test_a_new_map_has_no_masks(sessions: RobotSessions, store: MemoryStore) -> None:
    parameters = {"keepout_filter": {"filter_mask": "house"}}
    store.put_robot(records.robot("tb1", user="ann", map="new:office-2", parameters=parameters))
    with pytest.raises(InvalidParameter, match="a robot that makes a new map cannot have the mask 'house'"):
        await sessions.join("ann", "tb1", as_robot=True)
