"""Nodes that a clone has on request."""

import sys

import pytest

from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidParameter, Unavailable
from ppaas.nodes.graph import Graph
from tests.support.world.planar_world import walled_map


@pytest.mark.parametrize(
    ("maps", "parameters", "has"),
    [
        (False, {}, False),
        (False, {"depthimage_to_laserscan": {}}, False),
        (False, {"octomap_server": {"resolution": 0.1}}, True),
        (True, {}, False),
        (True, {"depthimage_to_laserscan": {}}, True),
    ],
)
def test_clone_has_the_node_if_its_robot_maps_with_a_depth_camera_or_has_parameters_for_it(maps, parameters, has):
    graph, layers = Graph(), build_layers(walled_map(4, 3, []))
    build_clone(
        graph, None if maps else layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=parameters
    )
    assert ("octomap_server" in graph.nodes) is has
    wrong = {"octomap_server": {"sensor_model": {"hit": 0.1}}}
    with pytest.raises(InvalidParameter, match="hit"):
        build_clone(Graph(), layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=wrong)


def test_registration_without_the_library_is_refused_when_the_clone_is_built(monkeypatch):
    monkeypatch.setitem(sys.modules, "small_gicp", None)
    layers, wanted = build_layers(walled_map(4, 3, [])), {"octomap_server": {"registration": True}}
    with pytest.raises(Unavailable, match="small_gicp"):
        build_clone(Graph(), layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=wanted)
