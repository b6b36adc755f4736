"""Nodes of a real clone leave its graph and return, with their state."""

from collections.abc import Sequence

import msgspec
import pytest

from engine.container.monitor.node_switch import GraphNodeSwitch
from engine.container.monitor.parameters import NodeMonitorParameters, monitor_parameters, with_priorities
from engine.container.monitor.setup import ContainerMonitor, of_clone
from engine.specs.containers import RobotConfig
from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidParameter, PPaaSError
from ppaas.maps.generate import office
from ppaas.messages import decode
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.message import Message
from ppaas.messages.ppaas_msgs import (
    GiveNodeRequest,
    HoldNodeRequest,
    HoldNodeResponse,
    NodeHome,
    RunNodeRequest,
    TellRobotRequest,
)
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.base import Payload
from ppaas.nodes.graph import Graph

ROBOT = RobotConfig("tb1", "turtlebot2", (2.0, 2.0, 0.5), "dijkstra", "dwa")


@pytest.fixture(scope="module")
def layers() -> MapLayers:
    return build_layers(office(seed=1, width=12.0, height=10.0))


def clone(graph: Graph, layers: MapLayers, only: Sequence[str] | None = None) -> None:
    build_clone(graph, layers, model=ROBOT.model, initial_pose=ROBOT.initial_pose, only=only)


def said(kind: type[Message]) -> Message:
    return decode(kind, {GoalID: b'{"id":"of nobody"}', LaserScan: SCAN}.get(kind, POSE))


SCAN = (
    b'{"header":{"frame_id":"base_scan"},"angle_min":0,"angle_max":1,"angle_increment":1,"range_min":0,"range_max":9,'
    b'"ranges":[1,1]}'
)
POSE = b'{"header":{"frame_id":"map"},"pose":{"pose":{"position":{"x":2,"y":2},"orientation":{"z":0,"w":1}}}}'


@pytest.mark.parametrize("node", ["amcl", "move_base", "waypoint_follower"])
def test_node_returns_with_unchanged_state_and_connections(node: str, layers: MapLayers) -> None:
    graph = Graph()
    clone(graph, layers)
    services, topics = dict(graph.services), dict(graph.topics)
    changes: list[set[str]] = []
    hands = GraphNodeSwitch(
        graph, ROBOT, lambda name: clone(graph, layers, (name,)), lambda: changes.append({*graph.nodes})
    )
    came: list[str] = []
    state = hands.take_out(node, lambda topic, _: came.append(topic))
    assert state.startswith("{")
    assert node not in graph.nodes
    assert graph.topics == topics, "subscribers of its topics stay subscribed"
    for topic in ("move_base/cancel", "initialpose", "follow_waypoints/cancel", "scan"):
        graph.inject(topic, said(graph.topic(topic).type))
    assert came and "scan" not in came
    hands.put_in(node, state)
    there = list(came)
    graph.inject("move_base/cancel", GoalID(id="of nobody"))
    assert came == there, "the node receives its topics itself again"
    assert graph.services == services
    assert (graph.nodes[node].checkpoint() or b"").decode() == state
    assert [node in there for there in changes] == [False, True]
    assert node in hands.nodes()


def test_node_returned_with_an_unreadable_state_starts_in_its_initial_state(
    layers: MapLayers, caplog: pytest.LogCaptureFixture
) -> None:
    graph = Graph()
    clone(graph, layers)
    monitoring = ContainerMonitor(graph, ROBOT, lambda names: clone(graph, layers, names))
    offers: list[bool] = []
    monitoring.changed = lambda: offers.append("amcl" in graph.nodes)
    answers: list[Payload | PPaaSError] = []
    requests: dict[str, Message] = {
        "tell_robot": TellRobotRequest(8, 3.0, 5.0, 0.3, 100e3, ["amcl"]),
        "run_node": RunNodeRequest("amcl", "robot"),
        "hold_node": HoldNodeRequest("amcl"),
    }
    for service, request in requests.items():
        graph.call(f"node_monitor/{service}", request, answers.append)
    taken = answers[-1]
    assert isinstance(taken, HoldNodeResponse)
    initial = taken.state
    graph.call("node_monitor/give_node", GiveNodeRequest("amcl", taken.lease, "rubbish"), answers.append)
    home = answers[-1]
    assert isinstance(home, NodeHome)
    assert home.home == "cloud"
    assert offers == [False, True], "its topics and services are offered again"
    assert (graph.nodes["amcl"].checkpoint() or b"").decode() == initial
    assert "the checkpoint of node 'amcl' cannot be read" in caplog.text


def test_parameters_of_monitor_and_recorder_do_not_reach_other_nodes(layers: MapLayers) -> None:
    said = {"node_monitor": {"priorities": ["network_bandwidth"]}, "recorder": {"ring_minutes": 1}, "amcl": {"seed": 3}}
    robot = RobotConfig("tb1", "turtlebot2", (2.0, 2.0, 0.0), "dijkstra", "dwa", said)
    assert of_clone(robot).parameters == {"amcl": {"seed": 3}}
    assert of_clone(msgspec.structs.replace(robot, urdf_text=b"text")) == of_clone(robot), "robots have their URDF"
    graph = Graph()
    ContainerMonitor(graph, robot, lambda _: None)
    assert list(graph.nodes) == ["node_monitor"]


@pytest.mark.parametrize("said", [{"priorities": ["luck"]}, {"patience": 0.1}, {"no": 1}, {"priorities": []}])
def test_invalid_parameter_is_refused(said: dict[str, object]) -> None:
    robot = RobotConfig("tb1", "turtlebot2", (2.0, 2.0, 0.0), "dijkstra", "dwa", {"node_monitor": said})
    with pytest.raises(InvalidParameter, match="node_monitor"):
        ContainerMonitor(Graph(), robot, lambda _: None)


def test_cloud_priorities_apply_if_the_robot_sets_none() -> None:
    cloud = ("network_bandwidth",)
    assert with_priorities({"amcl": {}}, cloud) == {"amcl": {}, "node_monitor": {"priorities": ["network_bandwidth"]}}
    own = {"node_monitor": {"priorities": ["node_properties"], "patience": 9.0}}
    assert with_priorities(own, cloud) == own
    merged = with_priorities({"node_monitor": {"patience": 9.0}}, cloud)
    assert monitor_parameters(merged["node_monitor"]) == NodeMonitorParameters(priorities=cloud, patience=9.0)
    assert with_priorities({}, ()) == {}
    assert with_priorities({"node_monitor": 3}, cloud) == {"node_monitor": 3}
