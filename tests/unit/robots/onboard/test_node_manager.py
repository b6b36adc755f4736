"""Local node manager after a cloud was killed and its client has a new session."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import msgspec
import pytest

from ppaas.errors import NotFound, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages import ppaas_msgs
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.fleet.traffic import ZonesOfMap
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.health.stops import StopState
from ppaas.messages.nav_msgs import GetMapResponse, MapMetaData, OccupancyGrid
from ppaas.messages.ppaas_msgs import NodeHome, NodeHomes
from ppaas.zones.reading import geojson_of, zones_of
from ppaas.zones.zone import NO_ZONES
from robots.onboard import node_manager
from robots.onboard.computer import Computer
from robots.onboard.executor import protocol
from robots.onboard.local_nodes import PlacementReporter, parse_wanted_homes
from robots.onboard.node_manager import NODES, LocalNodes
from tests.support.waiting import until

CONFIG = msgspec.json.encode(protocol.CloneConfig("turtlebot2", (0.0, 0.0, 0.0), "dijkstra", "dwa")).decode()
COMPUTER = Computer(4, 2.0, 2.2)


class FakeCloud:
    """Client of a cloud with a node monitor for Move Base alone."""

    def __init__(self) -> None:
        self.config = CONFIG
        self.connections = 1
        self.reports: list[ppaas_msgs.TellRobotRequest] = []
        self.asked: list[str] = []
        self.lease = self.leases = 0
        self.wanted = "cloud"
        self.unreachable_calls = 0
        self.waiting = asyncio.Event()
        self.waiting.set()
        self._tell: Any = None

    def forget(self) -> None:
        """Act as another node monitor, in a new session."""
        self.reports.clear()
        self.asked.clear()
        self.lease, self.leases, self.wanted = 0, 0, "cloud"
        self.connections += 1
        self._publish()

    def _publish(self) -> None:
        self._tell(self._homes())

    def _homes(self) -> ppaas_msgs.NodeHomes:
        return ppaas_msgs.NodeHomes([self._home()])

    def _home(self) -> ppaas_msgs.NodeHome:
        return ppaas_msgs.NodeHome("move_base", "robot" if self.lease else "cloud", self.wanted, 1.0, [])

    async def subscribe(self, topic: str, _: type[Message], callback: Any) -> None:
        if topic == "stop/state":
            callback(StopState())
        else:
            self._tell = callback

    def attach(self, _: object) -> None: ...

    async def call(self, service: str, _: object, request: Any, timeout: float = 10.0) -> Message:
        if self.unreachable_calls:
            self.unreachable_calls -= 1
            raise Unavailable("the container is being replaced")
        if service.endswith("hold_node"):
            await self.waiting.wait()
        answer: Message = getattr(self, service.rpartition("/")[2])(request)
        return answer

    def static_map(self, _: object) -> Message:
        return GetMapResponse(OccupancyGrid(Header(), MapMetaData(0.05, 1, 1, Pose.of(Pose2D(0.0, 0.0, 0.0))), [0]))

    def keepout_filter_mask(self, _: object) -> Message:
        return self.static_map(None)

    def speed_filter_mask(self, _: object) -> Message:
        return GetMapResponse(OccupancyGrid(Header(), MapMetaData(0.0, 0, 0, Pose.of(Pose2D(0.0, 0.0, 0.0))), []))

    def map_zones(self, _: object) -> Message:
        return ZonesOfMap(geojson_of(NO_ZONES).decode())

    def probe_link(self, request: ppaas_msgs.ProbeLinkRequest) -> Message:
        return ppaas_msgs.ProbeLinkResponse("0" * request.bytes)

    def tell_robot(self, request: ppaas_msgs.TellRobotRequest) -> Message:
        self.reports.append(request)
        return ppaas_msgs.TellRobotResponse(self.config, 1.0)

    def list_nodes(self, _: object) -> Message:
        return self._homes()

    def run_node(self, request: ppaas_msgs.RunNodeRequest) -> Message:
        self.asked.append(request.home)
        self.wanted = "robot"
        self._publish()
        return self._home()

    def hold_node(self, request: ppaas_msgs.HoldNodeRequest) -> Message:
        if request.lease == 0:
            self.leases += 1
            self.lease = self.leases
            return ppaas_msgs.HoldNodeResponse(self.lease, "its state")
        return ppaas_msgs.HoldNodeResponse(request.lease if request.lease == self.lease else 0)

    def give_node(self, request: ppaas_msgs.GiveNodeRequest) -> Message:
        self.lease, self.wanted = 0, "cloud"
        return self._home()


class FakeProcess:
    """Executor process that is ready at once."""

    pid, alive = 42, True

    begun: list[protocol.Begin]

    def __init__(self, *_: object) -> None: ...

    async def start(self, begin: protocol.Begin) -> None:
        self.begun.append(begin)

    async def stop(self) -> None: ...

    async def ask(self, frame: object, _: object) -> object:
        match frame:
            case protocol.Add():
                return protocol.Added(frame.node, [], [], [])
            case protocol.Remove():
                return protocol.Removed(frame.node, "its state")
        return protocol.States({})


@pytest.fixture
def cloud() -> FakeCloud:
    return FakeCloud()


@pytest.fixture
async def manager(cloud: FakeCloud, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[LocalNodes]:
    monkeypatch.setattr(FakeProcess, "begun", [], raising=False)
    monkeypatch.setattr(node_manager, "NodeProcess", FakeProcess)
    monkeypatch.setattr(node_manager, "HOLD_PERIOD", 0.001)
    made = LocalNodes(cloud, COMPUTER)  # type: ignore[arg-type]
    running = asyncio.create_task(made.run())
    await made.ready.wait()
    yield made
    assert not running.done(), running
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)


async def drives_itself(cloud: FakeCloud, manager: LocalNodes) -> None:
    await manager.ask("move_base")
    await until(lambda: manager.running == {"move_base"})
    assert (len(cloud.reports), cloud.asked) == (1, [""])


async def test_nodes_start_with_the_map_and_its_masks(cloud: FakeCloud, manager: LocalNodes) -> None:
    await drives_itself(cloud, manager)
    (begin,) = FakeProcess.begun
    assert list(begin.masks) == ["keepout_filter_mask"]
    assert begin.masks["keepout_filter_mask"] == begin.map
    assert zones_of(begin.zones) == NO_ZONES


async def test_nodes_of_a_robot_that_makes_a_map_start_without_one(
    cloud: FakeCloud, manager: LocalNodes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(FakeCloud, "static_map")
    config = msgspec.json.decode(CONFIG, type=protocol.CloneConfig)
    cloud.config = msgspec.json.encode(msgspec.structs.replace(config, new_map="office-2")).decode()
    cloud.forget()
    await until(lambda: cloud.reports)
    await manager.ask("move_base")
    await until(lambda: manager.running == {"move_base"})
    (begin,) = FakeProcess.begun
    assert (begin.map, begin.masks, begin.config.new_map) == (msgspec.Raw(b"null"), {}, "office-2")


async def test_local_nodes_continue_in_a_new_session(cloud: FakeCloud, manager: LocalNodes) -> None:
    await drives_itself(cloud, manager)
    cloud.unreachable_calls = 3
    cloud.forget()
    await until(lambda: cloud.lease == 1)
    await until(lambda: manager.running == {"move_base"})
    assert [report.cores for report in cloud.reports] == [4]
    assert cloud.asked == ["robot"]


async def test_a_delayed_hold_of_a_lost_session_releases_nothing(cloud: FakeCloud, manager: LocalNodes) -> None:
    await drives_itself(cloud, manager)
    cloud.waiting = asyncio.Event()
    await asyncio.sleep(0.02)
    cloud.forget()
    cloud.waiting.set()
    await until(lambda: cloud.asked == ["robot"] and manager.running == {"move_base"})
    assert cloud.lease == 1


async def test_nothing_is_requested_from_a_monitor_that_knows_the_nodes(cloud: FakeCloud, manager: LocalNodes) -> None:
    await drives_itself(cloud, manager)
    cloud.connections += 1
    await until(lambda: len(cloud.reports) == 2)
    await asyncio.sleep(0.02)
    assert (cloud.asked, cloud.lease, len(cloud.reports)) == ([""], 1, 2)
    assert manager.running == {"move_base"}


async def test_a_node_moved_to_the_cloud_stays_there_in_a_new_session(cloud: FakeCloud, manager: LocalNodes) -> None:
    await drives_itself(cloud, manager)
    cloud.wanted = "cloud"
    cloud._publish()
    await until(lambda: not manager.running and cloud.lease == 0)
    cloud.forget()
    await until(lambda: len(cloud.reports) == 1)
    await asyncio.sleep(0.02)
    assert (cloud.asked, manager.running) == ([], frozenset())


def test_auto_requests_all_nodes_and_names_request_the_robot() -> None:
    assert parse_wanted_homes("auto") == dict.fromkeys(NODES, "")
    assert parse_wanted_homes("move_base, amcl") == {"move_base": "robot", "amcl": "robot"}


@pytest.mark.parametrize("text", ["", "move_bas", "amcl,", "auto,amcl", "map_server"])
def test_unknown_nodes_are_refused_with_the_known_ones(text: str) -> None:
    with pytest.raises(NotFound, match=r"unknown local node .*; known: .*amcl.*auto.*move_base"):
        parse_wanted_homes(text)


def test_requested_nodes_are_reported_once_per_change() -> None:
    reports: list[str] = []
    homes = PlacementReporter(reports.append)
    homes.changed(NodeHomes([NodeHome("amcl"), NodeHome("move_base")]))
    assert reports == [], "no node was requested"
    going = NodeHome("move_base", "cloud", "robot", -1.0, ["a client requested this home"])
    there = NodeHome("move_base", "robot", "robot", -1.0, ["a client requested this home"])
    failed = ["it could not be run on the robot: it fell", "which is bad"]
    homes.note(going)
    for home in (going, there, there, NodeHome("move_base", "robot", "cloud", 1.0, failed)):
        homes.changed(NodeHomes([NodeHome("amcl"), home]))
    homes.changed(NodeHomes([NodeHome("move_base", "cloud", "cloud", 1.0, failed)]))
    assert reports == [
        "move_base moves to the robot: a client requested this home",
        "move_base runs on the robot: a client requested this home",
        "move_base moves back to the cloud: it could not be run on the robot: it fell; which is bad",
        "move_base runs in the cloud: it could not be run on the robot: it fell; which is bad",
    ]
