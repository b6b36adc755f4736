"""The map server."""

from ppaas.maps.occupancy import from_message
from ppaas.messages.codec import decode, encode
from ppaas.messages.message import Empty
from ppaas.messages.nav_msgs import GetMapResponse, OccupancyGrid
from ppaas.nodes.graph import Graph
from ppaas.nodes.map_server import MapServerNode
from tests.support.planar_world import walled_map

GRID = walled_map(3, 2, [(1, 1, 1.5, 1.2)])


def test_who_subscribes_gets_the_map_by_reference_and_makes_it_a_message_where_it_leaves():
    graph = Graph(stamp_clock=lambda: 12.5)
    graph.add(lambda context: MapServerNode(context, GRID))
    heard = []
    graph.tap("map", lambda _, payload: heard.append(payload))
    (lazy,) = heard
    assert lazy.grid is GRID
    message = decode(OccupancyGrid, encode(lazy.to_message()))
    assert message.header.frame_id == "map"
    assert message.info.map_load_time.seconds() == 12.5
    found = from_message(message)
    assert found.info == GRID.info
    assert (found.data == GRID.data).all()


def test_the_service_gives_the_map():
    graph = Graph()
    graph.add(lambda context: MapServerNode(context, GRID))
    answers = []
    graph.call("static_map", Empty(), answers.append)
    assert isinstance(answers[0], GetMapResponse)
    assert (from_message(answers[0].map).data == GRID.data).all()
