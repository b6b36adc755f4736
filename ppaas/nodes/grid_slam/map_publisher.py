"""Publisher of a map that grows: the whole map now and then, and its changes every second."""

import numpy as np
from numpy.typing import NDArray

from ppaas.mapping.live.map_canvas import MapCanvas
from ppaas.maps.cell_rectangle import Rectangle, changed_rectangles
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.occupancy import GridMapMessage, MapChange
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.geometry_msgs import Pose
from ppaas.messages.nav_msgs import MapMetaData
from ppaas.nodes import topics
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP

_NO_CELLS = np.empty((0, 0), np.int8)


class MapPublisher:
    """Publishes ``map``, ``map_metadata`` and ``map_updates``.

    The whole map is published when its size or its corner changes, and otherwise after ``interval``, if it has changed.
    Rectangles of ``map_updates`` refer to the last whole map.

    Parameters
    ----------
    context : Context
        Of the node.
    interval : float
        Time between two whole maps [s].
    """

    def __init__(self, context: Context, interval: float) -> None:
        self._context, self._interval = context, interval
        self._info: GridInfo | None = None
        self._cells: NDArray[np.int8] = _NO_CELLS
        self._canvas: MapCanvas | None = None
        self._changed, self._whole_at = False, 0.0

    def publish(self, canvas: MapCanvas) -> None:
        """Publish what has changed since the last call."""
        touched, fresh = canvas.take_touched(), canvas is not self._canvas
        self._canvas = canvas
        if canvas.extent is None:
            return
        if canvas.info != self._info:
            self._publish_whole(canvas)
            return
        within = Rectangle(0, 0, *canvas.extent.shape) if fresh else touched
        if within is not None:
            self._publish_changes(canvas, within)
        if self._changed and self._context.elapsed() - self._whole_at >= self._interval:
            self._publish_whole(canvas)

    def forget(self) -> None:
        """Forget the map, which was cleared; a later subscriber does not get it."""
        self._info, self._cells, self._canvas, self._changed = None, _NO_CELLS, None, False
        self._context.forget(topics.MAP.name)
        self._context.forget(topics.MAP_METADATA.name)

    def _publish_changes(self, canvas: MapCanvas, within: Rectangle) -> None:
        stamp = Time.of(self._context.now())
        for rectangle in changed_rectangles(self._cells, canvas.cells, within):
            cells = canvas.cells[rectangle.slices].copy()
            self._cells[rectangle.slices] = cells
            self._changed = True
            self._context.publish(topics.MAP_UPDATES.name, MapChange(cells, rectangle.row, rectangle.column, stamp))

    def _publish_whole(self, canvas: MapCanvas) -> None:
        stamp, info = Time.of(self._context.now()), canvas.info
        self._info, self._cells = info, canvas.cells.copy()
        self._changed, self._whole_at = False, self._context.elapsed()
        self._context.publish(topics.MAP.name, GridMapMessage(GridMap(canvas.cells.copy(), info), MAP, stamp))
        meta = MapMetaData(info.resolution, info.width, info.height, Pose.of(info.origin), stamp)
        self._context.publish(topics.MAP_METADATA.name, meta)
