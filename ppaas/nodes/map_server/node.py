"""The map server: gives the map of the clone to who asks, and the masks that lie on it."""

from typing import ClassVar

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.maps.occupancy import GridMapMessage
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.message import Message
from ppaas.messages.nav_msgs import GetMap, GetMapResponse, MapMetaData, OccupancyGrid
from ppaas.messages.std_msgs import Header, Time
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Reply, Service, Topic
from ppaas.nodes.frames import MAP

MAP_SERVICE = "static_map"
KEEPOUT_MASK, SPEED_MASK = "keepout_filter_mask", "speed_filter_mask"
"""Services that give masks of costmap filters, called as Nav2's documentation calls the topics of such masks."""


class MapServerNode(Node):
    """Publishes ``map``, latched, and answers ``static_map``, as ROS's map_server does; gives masks likewise.

    Parameters
    ----------
    context : Context
        Of its home.
    layers : MapLayers
        The map and its masks, by its cells; they are made messages only where they leave the home.
    """

    name: ClassVar[str] = "map_server"
    publishes: ClassVar[tuple[Topic, ...]] = (topics.MAP,)
    services: ClassVar[tuple[Service, ...]] = tuple(
        Service(name, GetMap) for name in (MAP_SERVICE, KEEPOUT_MASK, SPEED_MASK)
    )

    def __init__(self, context: Context, layers: MapLayers) -> None:
        super().__init__(context)
        grids = {MAP_SERVICE: layers.grid, KEEPOUT_MASK: layers.keepout, SPEED_MASK: layers.speed}
        stamp = Time.of(context.now())
        self._grids = {name: GridMapMessage(grid, MAP, stamp) for name, grid in grids.items() if grid is not None}

    def start(self) -> None:
        """Publish the map."""
        self.context.publish(topics.MAP.name, self._grids[MAP_SERVICE])

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Answer with the map, or with a mask; with a grid without cells where the robot has no such mask."""
        grid = self._grids.get(service)
        reply(GetMapResponse(_nothing() if grid is None else grid.to_message()))


def _nothing() -> OccupancyGrid:
    return OccupancyGrid(Header(frame_id=MAP), MapMetaData(0.0, 0, 0, Pose.of(Pose2D(0.0, 0.0))), [])
