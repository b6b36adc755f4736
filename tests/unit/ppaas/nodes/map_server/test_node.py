"""Node ``map_server``."""

import math

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidParameter
from ppaas.maps.cell_rectangle import Rectangle
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.occupancy import from_message, from_update
from ppaas.messages.base.message import Empty
from ppaas.messages.codec import decode, encode
from ppaas.messages.nav_msgs import GetMapResponse, OccupancyGrid
from ppaas.nodes.graph import Graph
from ppaas.nodes.map_server.costmap_filters import filter_masks
from ppaas.nodes.map_server.node import MapServerNode
from tests.support.world.planar_world import walled_map

GRID = walled_map(3, 2, [(1, 1, 1.5, 1.2)])
LAYERS = build_layers(GRID)
LARGE = walled_map(10, 8, [(1, 1, 1.5, 1.2)])
LARGE_LAYERS = build_layers(LARGE)


def call(layers: MapLayers, service: str):
    """Return the reply of a map server to a service call."""
    graph, answers = Graph(), []
    graph.add(lambda context: MapServerNode(context, layers))
    graph.call(service, Empty(), answers.append)
    return answers[0]


def test_subscriber_gets_the_map_by_reference():
    graph = Graph(stamp_clock=lambda: 12.5)
    graph.add(lambda context: MapServerNode(context, LAYERS))
    messages = []
    graph.tap("map", lambda _, payload: messages.append(payload))
    (lazy,) = messages
    assert lazy.grid is GRID
    message = decode(OccupancyGrid, encode(lazy.to_message()))
    assert message.header.frame_id == "map"
    assert message.info.map_load_time.seconds() == 12.5
    found = from_message(message)
    assert found.info == GRID.info
    assert (found.data == GRID.data).all()


def test_static_map_service_returns_the_map():
    answer = call(LAYERS, "static_map")
    assert isinstance(answer, GetMapResponse)
    assert (from_message(answer.map).data == GRID.data).all()


def test_mask_services_return_masks_on_the_maps_cells():
    mask = GridMap(np.array([[0, 100], [40, -1]], np.int8), GridInfo(1.0, 2, 2))
    layers = build_layers(GRID, keepout=mask, speed=mask)
    for service, expected in (("keepout_filter_mask", layers.keepout), ("speed_filter_mask", layers.speed)):
        found = from_message(call(layers, service).map)
        assert found.info == GRID.info
        assert (found.data == expected.data).all()
    assert set(np.unique(layers.keepout.data)) == {0, 40, 100}
    assert set(np.unique(layers.speed.data)) == {-1, 0, 40, 100}


def test_missing_mask_is_returned_empty():
    answer = decode(GetMapResponse, encode(call(LAYERS, "speed_filter_mask")))
    assert (answer.map.info.width, answer.map.info.height, answer.map.data) == (0, 0, [])


def changed(box: tuple[slice, slice], grid: GridMap = LARGE) -> MapLayers:
    """Return the layers of a map with other cells in a box."""
    data = grid.data.copy()
    data[box] = 100 - data[box]
    return build_layers(GridMap(data, grid.info))


def replaced(layers: MapLayers, changes=None):
    """Replace the map of a server; return its answer, the published messages, and what a later subscriber gets."""
    graph, published, later = Graph(), [], []
    server = graph.add(lambda context: MapServerNode(context, LARGE_LAYERS))
    for topic in ("map", "map_updates"):
        graph.tap(topic, lambda topic, payload: published.append((topic, payload)))
    published.clear()
    only_changes = server.use_layers(layers, changes)
    graph.tap("map", lambda _, payload: later.append(payload))
    assert (from_message(call_on(graph, "static_map").map).data == layers.grid.data).all()
    return only_changes, published, later[0]


def call_on(graph: Graph, service: str):
    answers = []
    graph.call(service, Empty(), answers.append)
    return answers[0]


def test_a_new_version_is_published_as_rectangles_and_whole_to_later_subscribers():
    layers = changed((slice(10, 20), slice(30, 33)))
    only_changes, published, later = replaced(layers)
    assert only_changes
    data = LARGE.data.copy()
    for topic, payload in published:
        assert topic == "map_updates"
        row, column, cells = from_update(payload.to_message())
        data[row : row + cells.shape[0], column : column + cells.shape[1]] = cells
    assert (data == layers.grid.data).all()
    assert later.grid is layers.grid
    assert (from_message(decode(OccupancyGrid, encode(later.to_message()))).data == layers.grid.data).all()


def test_given_rectangles_are_published():
    layers = changed((slice(10, 20), slice(30, 33)))
    _, published, _ = replaced(layers, [Rectangle(10, 30, 20, 33)])
    [(_, change)] = published
    assert (change.row, change.column, change.cells.shape) == (10, 30, (10, 3))


def test_the_whole_map_is_published_if_most_of_it_or_its_geometry_changed():
    other = walled_map(3.5, 2, [])
    for layers in (changed((slice(None), slice(None))), build_layers(other)):
        only_changes, published, later = replaced(layers)
        assert not only_changes
        assert [(topic, payload.grid) for topic, payload in published] == [("map", layers.grid)]
        assert later.grid is layers.grid


def test_an_equal_map_is_not_published():
    assert replaced(build_layers(LARGE))[:2] == (True, [])


def test_filter_masks_lists_the_masks_of_enabled_filters():
    keepout, speed = {"filter_mask": "kept"}, {"filter_mask": "slow", "base": 100, "multiplier": -1}
    assert filter_masks({"keepout_filter": keepout, "speed_filter": speed, "dwa": {}}) == {
        "keepout_filter": "kept",
        "speed_filter": "slow",
    }
    assert filter_masks({"keepout_filter": keepout | {"enabled": False}, "speed_filter": {}}) == {}
    assert filter_masks({}) == {}


@pytest.mark.parametrize(
    ("name", "parameters", "why"),
    [
        ("keepout_filter", {"mask": "kept"}, "known: enabled, filter_mask"),
        ("keepout_filter", {"filter_mask": 3}, "filter_mask"),
        ("speed_filter", {"filter_mask": "slow", "type": 0}, "type"),
        ("speed_filter", {"multiplier": math.inf}, "multiplier must be finite"),
        ("speed_filter", [], "speed_filter"),
    ],
)
def test_invalid_parameters_are_refused_by_name(name, parameters, why):
    with pytest.raises(InvalidParameter, match=why):
        filter_masks({name: parameters})
