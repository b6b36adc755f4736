"""Clones of robots that make a new map: their nodes and parameters."""

import json

import numpy as np
import pytest

from ppaas.clone.assembly import build_clone
from ppaas.clone.localization import BLANK, blank_layers, only
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import NO_INFORMATION
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidParameter, Unavailable
from ppaas.messages.base.rosapi import GetParamRequest
from ppaas.messages.slam_toolbox import DeserializePoseGraphRequest
from ppaas.nodes.graph import Graph
from tests.support.world.planar_world import walled_map

ON_MAP = build_layers(walled_map(4, 3, []))


def clone(parameters: dict[str, object], layers: MapLayers | None = None) -> Graph:
    graph = Graph()
    build_clone(graph, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=parameters)
    return graph


def value_of(graph: Graph, name: str) -> object:
    """Return the value of a parameter in use, False if there is none."""
    replies: list = []
    graph.call("rosapi/get_param", GetParamRequest(name, default="false"), replies.append)
    return json.loads(replies[0].value)


def test_a_robot_that_makes_a_map_has_grid_slam_in_place_of_amcl_and_the_map_server() -> None:
    graph, usual = clone({}), clone({}, ON_MAP)
    assert set(usual.nodes) - set(graph.nodes) == {"amcl", "map_server"}
    assert "grid_slam" in set(graph.nodes) - set(usual.nodes)
    assert {"dynamic_map", "save_map", "clear", "pause"} <= set(graph.services)
    assert {"map", "map_updates", "map_metadata", "pose", "amcl_pose", "grid_slam/status"} <= set(graph.topics)


def test_parameters_of_grid_slam_are_read_and_shown() -> None:
    graph = clone({"grid_slam": {"resolution": 0.1, "max_laser_range": 12.0}})
    assert value_of(graph, "/grid_slam/resolution") == 0.1
    assert value_of(graph, "/grid_slam/max_laser_range") == 12.0
    assert value_of(graph, "/amcl/max_particles") is False


def test_names_of_frames_are_those_of_grid_slam() -> None:
    graph = clone({"grid_slam": {"base_frame": "base_footprint", "odom_frame": "odom_combined"}})
    assert graph.nodes["move_base"]._surroundings.frames.names.base == "base_footprint"  # type: ignore[attr-defined]


@pytest.mark.parametrize("layers", [None, ON_MAP], ids=["new map", "published map"])
def test_parameters_of_the_other_localization_are_checked_but_not_in_use(layers: MapLayers | None) -> None:
    graph = clone({"grid_slam": {"resolution": 0.05}, "amcl": {"max_particles": 900}}, layers)
    in_use = {name: value_of(graph, f"/{name}") for name in ("grid_slam", "amcl")}
    assert (bool(in_use["grid_slam"]), bool(in_use["amcl"])) == (layers is None, layers is not None)
    for wrong in ({"grid_slam": {"resolutoin": 0.1}}, {"amcl": {"max_particle": 9}}):
        with pytest.raises(InvalidParameter, match="known: "):
            clone(wrong, layers)


@pytest.mark.parametrize("name", ["keepout_filter", "speed_filter"])
def test_a_new_map_has_no_masks(name: str) -> None:
    with pytest.raises(InvalidParameter, match=f"{name}: a robot that makes a new map cannot have the mask 'zones'"):
        clone({name: {"filter_mask": "zones"}})
    clone({name: {"filter_mask": "zones", "enabled": False}})


def test_a_clone_loads_the_pose_graph_of_the_map_that_it_continues_and_no_other() -> None:
    load = only("office", lambda name: name.encode())
    assert load("office") == b"office"
    with pytest.raises(Unavailable, match="pose graph 'lab' is not loaded here, but that of map 'office'"):
        load("lab")


def test_deserialize_map_refuses_the_name_of_another_map() -> None:
    graph = Graph()
    build_clone(
        graph, None, model="turtlebot2", initial_pose=(0.0, 0.0, 0.0),
        parameters={"grid_slam": {"map_file_name": ""}}, posegraph=lambda _: b"graph",
    )  # fmt: skip
    replies: list = []
    graph.call("deserialize_map", DeserializePoseGraphRequest("lab"), replies.append)
    assert isinstance(replies[0], Unavailable)


def test_a_new_map_begins_unknown_around_the_origin() -> None:
    layers = blank_layers(0.1)
    info = layers.grid.info
    assert info.shape == (BLANK, BLANK)
    assert info.resolution == 0.1
    assert info.cell_of(0.01, 0.01) == (BLANK // 2, BLANK // 2)
    assert np.all(layers.costmap.data == NO_INFORMATION)
