"""Numbers and names in node-monitor.md are those of the code."""

import itertools
import re

import msgspec

from engine.container.monitor.node import NodeMonitorNode
from engine.container.monitor.parameters import CRITERIA, NodeMonitorParameters
from ppaas.clone.assembly import DEPTH_CAMERA, LASER_PROC, build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.maps.generate import office
from ppaas.nodes.depthimage_to_laserscan.node import DepthImageToLaserScanNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.topics import CLOUD_IN, NODE_HOMES, TOPICS
from robots.onboard.node_manager import HOLD_PERIOD, NODES
from tests.support.documents import blocks, table, text_of

PAGE = "docs/node-monitor.md"


def test_services_and_topic_are_those_of_the_node_monitor() -> None:
    listed = table(PAGE, "service of the node monitor", "type", "caller and purpose")
    assert {name: kind for name, kind, _ in listed} == {s.name: s.type.name for s in NodeMonitorNode.services}
    assert f"`{NODE_HOMES.name}`" in text_of(PAGE)
    assert f"every {HOLD_PERIOD:g} s" in text_of(PAGE)


def test_parameters_and_defaults_are_those_of_the_code() -> None:
    rows = itertools.takewhile(lambda row: row[1] != "type", table(PAGE, "parameter", "default", "meaning"))
    listed = {name: default for name, default, _ in rows}
    defaults = msgspec.structs.asdict(NodeMonitorParameters())
    assert tuple(re.findall(r"\w+", listed.pop("priorities"))) == defaults.pop("priorities") == CRITERIA
    assert (listed.pop("time_critical"), defaults.pop("time_critical")) == ("none", ())
    assert {name: float(value) for name, value in listed.items()} == defaults


def test_the_example_of_a_robot_file_is_readable() -> None:
    [block] = blocks(PAGE, "json")
    settings = msgspec.json.decode(block)["node_monitor"]
    assert msgspec.convert(settings, NodeMonitorParameters).time_critical == ("move_base",)


def test_criteria_and_nodes_are_those_of_the_code() -> None:
    assert [row[0] for row in table(PAGE, "criterion", "vote")] == list(CRITERIA)
    graph = Graph()
    layers = build_layers(office(seed=1, width=12.0, height=10.0))
    some = {DEPTH_CAMERA: {}, LASER_PROC: {}, "torso_detector": {}, "leg_detector": {}, "follow_person": {}}
    build_clone(graph, layers, model="turtlebot2", initial_pose=(2.0, 2.0, 0.0), parameters=some)
    build_clone(graph, None, model="turtlebot2", initial_pose=(2.0, 2.0, 0.0), only=["grid_slam"])
    assert {name for name, node in graph.nodes.items() if node.demands is not None} == set(NODES)
    assert {*DepthImageToLaserScanNode.subscribes, CLOUD_IN} == {topic for topic in TOPICS.values() if topic.local}
    assert all(f"`{node}`" in text_of(PAGE) for node in NODES)
