"""The map server: gives the map of the clone to who asks."""

from typing import ClassVar

from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import GridMapMessage
from ppaas.messages.message import Message
from ppaas.messages.nav_msgs import GetMap, GetMapResponse, OccupancyGrid
from ppaas.messages.std_msgs import Time
from ppaas.nodes.base import Context, Node, Reply, Service, Topic
from ppaas.nodes.frames import MAP


class MapServerNode(Node):
    """Publishes ``map``, latched, and answers ``static_map``, as ROS's map_server does.

    Parameters
    ----------
    context : Context
        Of its home.
    grid : GridMap
        The map; it is made a message only where it leaves the home.
    """

    name: ClassVar[str] = "map_server"
    publishes: ClassVar[tuple[Topic, ...]] = (Topic("map", OccupancyGrid, latched=True),)
    services: ClassVar[tuple[Service, ...]] = (Service("static_map", GetMap),)

    def __init__(self, context: Context, grid: GridMap) -> None:
        super().__init__(context)
        self._map = GridMapMessage(grid, MAP, Time.of(context.now()))

    def start(self) -> None:
        """Publish the map."""
        self.context.publish("map", self._map)

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Answer with the map."""
        reply(GetMapResponse(self._map.to_message()))
