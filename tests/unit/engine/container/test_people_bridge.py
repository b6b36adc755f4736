"""People bridge: reports of clones to coordinators, and the state of the people to clones."""

import logging
from collections.abc import AsyncIterator
from dataclasses import dataclass

import pytest

from engine.container.executor import NodeExecutor
from engine.container.group_bridges import PEOPLE_PERIOD, GroupBridge, people_bridge
from engine.container.machine_client import MachineClient
from engine.protocols import machine_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import ContainerSpec, Launch
from ppaas.clock import ManualClock
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages import encode
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance
from ppaas.messages.people_coordination import PeopleReport, PeopleState
from ppaas.nodes.base import Node, Payload
from ppaas.nodes.graph import Graph
from ppaas.nodes.topics import PEOPLE_REPORT, PEOPLE_STATE
from tests.support.engine.engine_links import pair, receive
from tests.support.engine.specs import coordinator_spec, mapping_spec, robot_spec

STATE = PeopleState(Header(frame_id="map"), 2)


def report(robot: str = "tb1", following: int = 0) -> PeopleReport:
    return PeopleReport(Header(frame_id="map"), robot, PoseWithCovariance(Pose.of(Pose2D(0, 0))), following=following)


class Listener(Node):
    """Keeps what it receives, and refuses reports of robots that follow somebody."""

    name = "listener"
    subscribes = (PEOPLE_REPORT, PEOPLE_STATE)

    def start(self) -> None:
        self.heard: list[Payload] = []

    def on_message(self, topic: str, message: Payload) -> None:
        if isinstance(message, PeopleReport) and message.following == 1:
            raise InvalidInput("it follows")
        if isinstance(message, PeopleReport) and message.following == 2:
            raise ZeroDivisionError
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

    def shared(self, topic: str, payload: bytes, robot: str = "tb1") -> None:
        self.bridge.shared(machine_link.Shared("ann", robot, topic, payload))

    async def sent(self) -> list[bytes]:
        """Return the payloads that were shared, after a last one that ends them."""
        self.client.share("end", b"")
        payloads = []
        while (frame := await receive(self.machine)) != machine_link.FabricPublish("end", b""):
            payloads.append(frame.payload)
        return payloads


async def bridged(spec: ContainerSpec) -> Bridged:
    near, far = await pair(machine_link.ToContainer, machine_link.FromContainer)
    client, clock, home = MachineClient(near), ManualClock(10.0), NodeExecutor(lambda: None)
    home.graph = Graph(clock=clock)
    node = home.graph.add(Listener)
    launch = Launch(spec, "", "", "", "secret", (0,), 1)
    return Bridged(home.graph, node, people_bridge(launch, home, client, lambda: True), clock, far, client)


@pytest.fixture
async def made(request: pytest.FixtureRequest) -> AsyncIterator[Bridged]:
    one = await bridged(request.param)
    yield one
    await one.client.close()
    await one.machine.close()


ROBOT, COORDINATOR = robot_spec(), coordinator_spec()


@pytest.mark.parametrize("made", [ROBOT], indirect=True)
async def test_a_clone_shares_reports_at_a_limited_rate_and_no_state(made: Bridged) -> None:
    for number in range(3):
        made.graph.publish(PEOPLE_REPORT.name, report(following=number + 3))
        made.clock.advance(PEOPLE_PERIOD * 0.6)
    made.graph.publish(PEOPLE_STATE.name, STATE)
    assert await made.sent() == [encode(report(following=3)), encode(report(following=5))]


@pytest.mark.parametrize("made", [mapping_spec()], indirect=True)
async def test_a_robot_that_makes_a_map_shares_no_reports(made: Bridged) -> None:
    made.graph.publish(PEOPLE_REPORT.name, report())
    assert await made.sent() == []


@pytest.mark.parametrize("made", [COORDINATOR], indirect=True)
async def test_a_coordinator_shares_the_state_and_no_reports(made: Bridged) -> None:
    made.graph.publish(PEOPLE_REPORT.name, report())
    made.graph.publish(PEOPLE_STATE.name, STATE)
    assert await made.sent() == [encode(STATE)]


@pytest.mark.parametrize("made", [ROBOT], indirect=True)
async def test_a_clone_takes_the_state_alone(made: Bridged) -> None:
    made.shared(PEOPLE_STATE.name, encode(STATE), "_coordinator")
    made.shared(PEOPLE_REPORT.name, encode(report()))
    made.shared("amcl_pose", b"{}")
    assert made.node.heard == [STATE]


@pytest.mark.parametrize("made", [COORDINATOR], indirect=True)
async def test_a_coordinator_takes_reports_in_the_name_of_their_robot_alone(
    made: Bridged, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            made.shared(PEOPLE_REPORT.name, encode(report("tb1")), "tb2")
        made.shared(PEOPLE_REPORT.name, encode(report("tb3", following=1)), "tb3")
        made.shared(PEOPLE_REPORT.name, encode(report("tb4", following=2)), "tb4")
        made.shared(PEOPLE_REPORT.name, b"{", "tb5")
        made.shared(PEOPLE_STATE.name, encode(STATE), "_coordinator")
        made.shared(PEOPLE_REPORT.name, encode(report("tb1")), "tb1")
    assert made.node.heard == [report("tb1")]
    texts = [record.getMessage() for record in caplog.records if record.name == "engine.container.group_bridges"]
    assert [text.partition(" of ")[2][:3] for text in texts] == ["tb2", "tb3", "tb4", "tb5"], "each once"
    assert "it names robot 'tb1'" in texts[0] and "it follows" in texts[1]


async def test_a_clone_without_nodes_for_people_takes_and_shares_nothing() -> None:
    one = await bridged(ROBOT)
    empty = NodeExecutor(lambda: None)
    bridge = people_bridge(Launch(ROBOT, "", "", "", "secret", (0,), 1), empty, one.client, lambda: True)
    bridge.shared(machine_link.Shared("ann", "_coordinator", PEOPLE_STATE.name, encode(STATE)))
    assert empty.graph.topics == {}
    await one.client.close()
    await one.machine.close()
