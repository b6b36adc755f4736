"""What must arrive, and what the next message makes up for."""

from ppaas.clone.assembly import DEPTH_CAMERA, build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.nodes.delivery_qos import STREAMS, must_arrive
from ppaas.nodes.graph import Graph
from tests.support.world.planar_world import walled_map


def test_what_streams_is_what_a_clone_knows_and_what_is_said_once_must_arrive() -> None:
    graph = Graph()
    layers = build_layers(walled_map(4, 3, []))
    build_clone(graph, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters={DEPTH_CAMERA: {}})
    assert set(graph.topics) >= STREAMS
    said_once = {"camera/depth/camera_info", "initialpose", "move_base/goal", "move_base/cancel", "move_base/result"}
    assert {topic for topic in said_once if must_arrive(topic)} == said_once
