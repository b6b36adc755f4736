"""Groups of robots that take part in the traffic of their map, and the places of their traffic nodes."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from engine.control.group_places import LONGEST_RETRY, RETRY, STEADY, PeopleGroups
from engine.control.master_driver import CloudListener, MasterDriver
from engine.control.traffic_groups import TRAFFIC_LINGER, TrafficGroups
from engine.master.balancers.first_fit import FirstFit
from engine.master.master import Master
from engine.master.places import PlaceRequest
from engine.master.quotas import Quota, Quotas
from engine.protocols import robot_link
from engine.specs.checkpoints import CheckpointSelection
from engine.specs.containers import MapVersion
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.fleet.traffic import RobotOfTraffic, TrafficState
from ppaas.nodes.traffic import node
from ppaas.traffic.taking_part import TRAFFIC, takes_part, with_traffic
from storage.memory.store import MemoryStore
from storage.records import Limits
from tests.support.engine.fake_machine import FakeMachine, FarContainer
from tests.support.engine.specs import HOUSE, robot_request, traffic_request

KEY = "traffic:ann/house"
GONE = Unavailable("it has gone")


def driving(robot: str = "tb1", **fields: object) -> PlaceRequest:
    """Return a request for a robot that takes part."""
    return robot_request(robot, cores=0.25, parameters={"traffic": {}}, **fields)  # type: ignore[arg-type]


class Groups(CloudListener):
    """Groups of a cloud, as its engine connects them, by a clock that the test sets."""

    def __init__(self, folder: Path) -> None:
        self.clock = ManualClock(100.0)
        master = Master(FirstFit(), Quotas(Quota(containers=6)))
        self.service = MasterDriver(master, CheckpointSelection(MemoryStore()), folder, "secret", self)
        self.traffic = TrafficGroups(self.service, self.clock)
        self.people = PeopleGroups(self.service, self.clock)

    def place_opened(self, key: str) -> None:
        for groups in (self.traffic, self.people):
            groups.places.place_opened(key)

    def is_open(self, key: str = KEY) -> bool:
        return self.service.place(key) is not None

    def connect(self, request: PlaceRequest) -> None:
        """Open the place of a robot, as if its container were ready."""
        self.service.open_place(request).container = "c"

    async def after(self, seconds: float) -> None:
        self.clock.advance(seconds)
        for groups in (self.traffic, self.people):
            await groups.places.step()


@pytest.fixture
async def groups(tmp_path: Path) -> AsyncIterator[Groups]:
    made = Groups(tmp_path)
    await made.service.start()
    yield made
    for one in (made.traffic, made.people):
        one.places.close()
    await made.service.close()


async def answer(far: FarContainer, service: str, answered: bytes) -> bytes:
    """Answer a call; return its request."""
    call = await far.next()
    assert isinstance(call, robot_link.ServiceCall) and call.service == f"traffic/{service}"
    far.stream.write(robot_link.ServiceAnswer(call.call, answered))
    return bytes(call.payload)


async def test_one_robot_that_takes_part_brings_a_traffic_node_and_the_last_takes_it(groups: Groups) -> None:
    groups.connect(robot_request("free"))
    place = groups.service.open_place(driving())
    await groups.after(0.0)
    assert not groups.is_open(), "the robot starts first"
    place.container = "c"
    await groups.after(0.0)
    assert groups.service.request_of(KEY) == traffic_request()
    assert not groups.is_open("people:ann/house"), "nobody tracks people"
    await groups.service.close_place("robot:ann/tb1", GONE)
    await groups.after(TRAFFIC_LINGER * 0.9)
    assert groups.is_open()
    await groups.after(TRAFFIC_LINGER)
    assert not groups.is_open()


async def test_a_robot_may_be_in_a_group_of_each_kind(groups: Groups) -> None:
    groups.connect(robot_request("tb1", parameters={"traffic": {}, "torso_detector": {}}))
    await groups.after(0.0)
    assert groups.is_open() and groups.is_open("people:ann/house")


async def test_each_user_and_map_has_a_group_and_new_maps_have_none(groups: Groups) -> None:
    others = [driving(user="bob"), driving("tb2", version=MapVersion("depot", "v1")), driving("tb3", new_map="attic")]
    for request in others:
        groups.connect(request)
    await groups.after(0.0)
    assert groups.is_open("traffic:bob/house") and groups.is_open("traffic:ann/depot")
    assert sorted(groups.traffic.places.groups) == [("ann", "depot"), ("bob", "house")]


async def test_without_a_traffic_node_the_error_says_why_and_what_to_do(groups: Groups) -> None:
    with pytest.raises(Unavailable, match="set 'traffic' to true in the file of one"):
        await groups.traffic.state("ann", "house")
    groups.service.set_limits("ann", Limits(containers=1))
    groups.connect(driving())
    with pytest.raises(Unavailable, match="no robot of user 'ann'"):
        await groups.traffic.take_out("ann", "house", "tb1")
    await groups.after(0.0)
    with pytest.raises(Unavailable, match=r"the traffic node of map 'house' has no container: .*1 containers"):
        await groups.traffic.put_back("ann", "house", "tb1")
    groups.service.set_limits("ann", Limits(containers=2))
    await groups.after(RETRY)
    assert groups.is_open()


async def test_a_traffic_node_answers_also_after_its_robots_have_gone(groups: Groups, tmp_path: Path) -> None:
    machine = await FakeMachine.join(tmp_path)
    await machine.welcome
    place = groups.service.open_place(driving())
    await machine.boot(await machine.started())
    await place.ready(10)
    await groups.after(0.0)
    far = await machine.boot(await machine.started())
    assert (far.spec.traffic, far.spec.map, far.spec.kind) == (True, HOUSE, "traffic")
    await groups.service.close_place("robot:ann/tb1", GONE)
    await groups.after(0.0)
    state = TrafficState(Header(frame_id="map"), 3, 0.5)
    found, _ = await asyncio.gather(groups.traffic.state("ann", "house"), answer(far, "get_traffic", encode(state)))
    assert found == state
    for service, call in (("take_out", groups.traffic.take_out), ("put_back", groups.traffic.put_back)):
        _, asked = await asyncio.gather(call("ann", "house", "tb1"), answer(far, service, encode(Empty())))
        assert decode(RobotOfTraffic, asked) == RobotOfTraffic("tb1")
    await far.stream.close()
    await machine.leave()


async def test_traffic_nodes_end_with_their_map(groups: Groups) -> None:
    for request in (traffic_request(), driving("tb2", version=MapVersion("depot", "v1"))):
        groups.connect(request)
    await groups.after(0.0)
    await groups.traffic.places.close_map("house")
    assert not groups.is_open() and groups.is_open("traffic:ann/depot")


def test_the_key_of_a_robot_file_becomes_parameters_of_the_traffic_node() -> None:
    assert node.TRAFFIC == TRAFFIC
    others, own = {"amcl": {"a": 1}}, {"traffic": {"b": 2}}
    assert with_traffic(others, True) == others | {"traffic": {}}
    assert with_traffic(others | own, True) == others | own
    assert with_traffic(others | own, {"c": 3}) == others | {"traffic": {"c": 3}}
    assert with_traffic(others | own, False) == others
    assert takes_part(own) and not takes_part(others)


async def test_a_traffic_node_that_crashes_soon_after_each_start_is_restarted_ever_more_rarely(groups: Groups) -> None:
    async def crash_after(seconds: float) -> float:
        """Let the node run for some time and crash; return the time until its place is open again [s]."""
        place = groups.service.place(KEY)
        assert place is not None
        place.container = "c"
        await groups.after(0.0)
        await groups.after(seconds)
        await groups.service.close_place(KEY, GONE)
        waited = 0.0
        await groups.after(0.0)
        while not groups.is_open():
            await groups.after(2.5)
            waited += 2.5
        return waited

    groups.connect(driving())
    await groups.after(0.0)
    assert [await crash_after(20.0) for _ in range(6)] == [RETRY * factor for factor in (1, 2, 4, 8, 12, 12)]
    assert LONGEST_RETRY == 12 * RETRY
    assert await crash_after(STEADY) == RETRY


async def test_the_traffic_node_forgets_a_robot_that_goes_on_on_another_map(groups: Groups, tmp_path: Path) -> None:
    machine = await FakeMachine.join(tmp_path)
    await machine.welcome
    place = groups.service.open_place(driving())
    robot = await machine.boot(await machine.started())
    await place.ready(10)
    await groups.after(0.0)
    node = await machine.boot(await machine.started())
    await groups.traffic.places.place("ann", "house").ready(10)  # type: ignore[union-attr]
    groups.service.move_place(driving(version=MapVersion("loft", "v1")))
    assert await machine.stopped() == robot.spec.id
    await groups.after(0.0)
    there = await machine.boot(await machine.started())
    assert there.spec.traffic and there.spec.map.id == "loft"
    await machine.kill(robot, 0)
    again = await machine.boot(await machine.started())
    assert (again.spec.map.id, again.spec.session) == ("loft", robot.spec.session)
    await place.ready(10)
    await groups.after(0.0)
    call = await node.next()
    assert isinstance(call, robot_link.ServiceCall) and call.service == "traffic/let_go", "once, after it has left"
    assert decode(RobotOfTraffic, call.payload) == RobotOfTraffic("tb1")
    node.stream.write(robot_link.ServiceAnswer(call.call, encode(Empty())))
    await groups.after(0.0)
    for far in (node, there, again):
        await far.stream.close()
    await machine.leave()
