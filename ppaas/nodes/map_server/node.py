"""Node ``map_server``: provides the map of the clone and the masks of its costmap filters."""

import math
from collections.abc import Sequence
from typing import ClassVar

from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D
from ppaas.maps.cell_rectangle import Rectangle, changed_rectangles
from ppaas.maps.occupancy import GridMapMessage, GridUpdate
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import GetZones, ZonesOfMap
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import GetMap, GetMapResponse, MapMetaData, OccupancyGrid
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Reply, Service, Topic
from ppaas.nodes.frames import MAP
from ppaas.zones.reading import geojson_of

MAP_SERVICE = "static_map"

MOST_CHANGED = 0.5
"""Share of the cells in changed rectangles above which the whole map is published."""

KEEPOUT_MASK, SPEED_MASK = "keepout_filter_mask", "speed_filter_mask"
"""Services that return masks of costmap filters, named like the mask topics in Nav2's documentation."""

ZONES = "map_zones"
"""Service that returns the zones of the map."""


class MapServerNode(Node):
    """Publishes ``map``, latched, and answers ``static_map``, as ROS's map_server does; serves masks likewise.

    When the map is replaced by another version of the same size and origin, ``map_updates`` has the rectangles that
    changed, and ``map`` is for later subscribers. Otherwise ``map`` is published again.

    Parameters
    ----------
    context : Context
        The node's context.
    layers : MapLayers
        The map and its masks; they are converted to messages only when they leave the executor.
    """

    name: ClassVar[str] = "map_server"
    publishes: ClassVar[tuple[Topic, ...]] = (topics.MAP, topics.MAP_UPDATES)
    services: ClassVar[tuple[Service, ...]] = (
        *(Service(name, GetMap) for name in (MAP_SERVICE, KEEPOUT_MASK, SPEED_MASK)),
        Service(ZONES, GetZones),
    )

    def __init__(self, context: Context, layers: MapLayers) -> None:
        super().__init__(context)
        self._keep(layers)

    def _keep(self, layers: MapLayers) -> None:
        grids = {MAP_SERVICE: layers.grid, KEEPOUT_MASK: layers.keepout, SPEED_MASK: layers.speed}
        stamp = Time.of(self.context.now())
        self._grids = {name: GridMapMessage(grid, MAP, stamp) for name, grid in grids.items() if grid is not None}
        self._zones = layers.zones

    def start(self) -> None:
        """Publish the map."""
        self.context.publish(topics.MAP.name, self._grids[MAP_SERVICE])

    def use_layers(self, layers: MapLayers, changes: Sequence[Rectangle] | None = None) -> bool:
        """Replace the map and its masks.

        Parameters
        ----------
        layers : MapLayers
            The new map.
        changes : sequence of Rectangle, optional
            Rectangles without overlap that cover the cells that differ; compared here by default.

        Returns
        -------
        bool
            Whether only changes were published, and not the whole map.
        """
        before, after = self._grids[MAP_SERVICE].grid, layers.grid
        self._keep(layers)
        whole = self._grids[MAP_SERVICE]
        if before.info != after.info:
            self.context.publish(topics.MAP.name, whole)
            return False
        if changes is None:
            changes = changed_rectangles(before.data, after.data, Rectangle(0, 0, *after.info.shape))
        if sum(math.prod(one.shape) for one in changes) > MOST_CHANGED * after.data.size:
            self.context.publish(topics.MAP.name, whole)
            return False
        self.context.latch(topics.MAP.name, whole)
        for one in changes:
            change = GridUpdate(after.data[one.slices], one.row, one.column, whole.stamp or Time())
            self.context.publish(topics.MAP_UPDATES.name, change)
        return True

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Reply with the map or a mask, or with a grid without cells if the robot has no such mask; or with zones."""
        if service == ZONES:
            reply(ZonesOfMap(geojson_of(self._zones).decode()))
            return
        grid = self._grids.get(service)
        reply(GetMapResponse(_nothing() if grid is None else grid.to_message()))


def _nothing() -> OccupancyGrid:
    return OccupancyGrid(Header(frame_id=MAP), MapMetaData(0.0, 0, 0, Pose.of(Pose2D(0.0, 0.0))), [])
