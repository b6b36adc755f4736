"""Node ``map_server``."""

import numpy as np

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.occupancy import from_message
from ppaas.messages.codec import decode, encode
from ppaas.messages.message import Empty
from ppaas.messages.nav_msgs import GetMapResponse, OccupancyGrid
from ppaas.nodes.graph import Graph
from ppaas.nodes.map_server.node import MapServerNode
from tests.support.world.planar_world import walled_map

GRID = walled_map(3, 2, [(1, 1, 1.5, 1.2)])
LAYERS = build_layers(GRID)


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
