"""Traffic bridge: reports of clones to traffic nodes, and grants to the robot that they are for."""

import logging
from collections.abc import AsyncIterator
from dataclasses import dataclass

import pytest
from msgspec.structs import replace

from engine.container.executor import NodeExecutor
from engine.container.group_bridges import TRAFFIC_PERIOD, GroupBridge, traffic_bridge
from engine.container.machine_client import MachineClient
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import ContainerSpec, Launch
from ppaas.clock import ManualClock
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.fleet.traffic import TrafficGrants, TrafficReport
from ppaas.nodes.base import Node, Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.topics import TRAFFIC_GRANTS, TRAFFIC_REPORT
from tests.support.engine.engine_links import pair, receive
from tests.support.engine.specs import coordinator_spec, mapping_spec, robot_spec, traffic_spec


def report(robot: str = "tb1", x: float = 1.0) -> TrafficReport:
    return TrafficReport(Header(frame_id="map"), robot, x, 2.0, 0.0, 0.2, 0.5, 0.3)


def grants(robot: str = "tb1") -> TrafficGrants:
    return TrafficGrants(Header(frame_id="map"), robot, 1, 1, 0, 0.5)


class Listener(Node):
    """Keeps what it receives."""

    name = "listener"
    subscribes = (TRAFFIC_REPORT, TRAFFIC_GRANTS)

    def start(self) -> None:
        self.heard: list[Payload] = []

    def on_message(self, topic: str, message: Payload) -> None:
        self.heard.append(message)


@dataclass
class Bridged:
    """A graph with its bridge, and the machine's end of its link."""

    graph: Graph
    node: Listener
    bridge: GroupBridge
    clock: ManualClock
    machine: FrameStream[machine_link.FromContainer]
    client: MachineClient
    here: list[bool]

    def shared(self, topic: str, payload: bytes, robot: str) -> None:
        self.bridge.shared(machine_link.Shared("ann", robot, topic, payload))

    async def sent(self) -> list[machine_link.FabricPublish]:
        """Return what was shared, after a last message that ends it."""
        self.client.share("end", b"")
        frames = []
        while (frame := await receive(self.machine)) != machine_link.FabricPublish("end", b""):
            frames.append(frame)
        return frames


@pytest.fixture
async def made(request: pytest.FixtureRequest) -> AsyncIterator[Bridged]:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client, clock, home = MachineClient(near), ManualClock(10.0), NodeExecutor(lambda: None)
    home.graph = Graph(clock=clock)
    node, spec = home.graph.add(Listener), request.param
    assert isinstance(spec, ContainerSpec)
    here = [True]
    bridge = traffic_bridge(Launch(spec, "", "", "", "secret", (0,), 1), home, client, lambda: here[-1])
    yield Bridged(home.graph, node, bridge, clock, far, client, here)
    await client.close()
    await far.close()


ROBOT, NODE = robot_spec(), traffic_spec()


@pytest.mark.parametrize("made", [ROBOT], indirect=True)
async def test_a_clone_shares_reports_at_a_limited_rate_and_no_grants(made: Bridged) -> None:
    for x in (0.0, 1.0, 2.0):
        made.graph.publish(TRAFFIC_REPORT.name, report(x=x))
        made.clock.advance(TRAFFIC_PERIOD * 0.6)
    made.graph.publish(TRAFFIC_GRANTS.name, grants())
    assert await made.sent() == [machine_link.FabricPublish("traffic/report", encode(report(x=x))) for x in (0.0, 2.0)]


@pytest.mark.parametrize("made", [ROBOT], indirect=True)
async def test_the_clone_of_a_robot_that_is_away_reports_nothing(made: Bridged) -> None:
    made.here.append(False)
    made.graph.publish(TRAFFIC_REPORT.name, report(x=0.0))
    made.here.append(True)
    made.graph.publish(TRAFFIC_REPORT.name, report(x=1.0))
    assert await made.sent() == [machine_link.FabricPublish("traffic/report", encode(report(x=1.0)))]


@pytest.mark.parametrize("made", [mapping_spec(), coordinator_spec()], indirect=True)
async def test_robots_that_make_a_map_and_coordinators_share_nothing(made: Bridged) -> None:
    made.graph.publish(TRAFFIC_REPORT.name, report())
    made.graph.publish(TRAFFIC_GRANTS.name, grants())
    assert await made.sent() == []


@pytest.mark.parametrize("made", [NODE], indirect=True)
async def test_a_traffic_node_shares_grants_with_the_robot_that_they_are_for(made: Bridged) -> None:
    made.graph.publish(TRAFFIC_REPORT.name, report())
    for robot in ("tb1", "tb2"):
        made.graph.publish(TRAFFIC_GRANTS.name, grants(robot))
    assert await made.sent() == [
        machine_link.FabricPublish("traffic/grants", encode(grants(robot)), robot) for robot in ("tb1", "tb2")
    ]


@pytest.mark.parametrize("made", [ROBOT], indirect=True)
async def test_a_clone_takes_grants_for_its_own_robot_alone(made: Bridged, caplog: pytest.LogCaptureFixture) -> None:
    made.shared(TRAFFIC_GRANTS.name, encode(grants("tb2")), "_traffic")
    made.shared(TRAFFIC_REPORT.name, encode(report()), "tb2")
    made.shared("amcl_pose", b"{}", "tb2")
    made.shared(TRAFFIC_GRANTS.name, encode(grants()), "_traffic")
    assert made.node.heard == [grants()]
    [record] = [record for record in caplog.records if record.levelno == logging.WARNING]
    assert "it names robot 'tb2'" in record.getMessage()


@pytest.mark.parametrize("made", [NODE], indirect=True)
async def test_a_traffic_node_takes_reports_in_the_name_of_their_robot_alone(
    made: Bridged, caplog: pytest.LogCaptureFixture
) -> None:
    for payload in (encode(report("tb1")), encode(replace(report(), robot="")), b"{"):
        made.shared(TRAFFIC_REPORT.name, payload, "tb2")
    made.shared(TRAFFIC_GRANTS.name, encode(grants()), "tb1")
    made.shared(TRAFFIC_REPORT.name, encode(report("tb1")), "tb1")
    assert made.node.heard == [report("tb1")]
    assert "it names robot 'tb1'" in caplog.text
