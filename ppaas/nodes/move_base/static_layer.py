"""Static layer of costmap_2d: the map of Move Base comes from the topics ``map`` and ``map_updates``, and changes."""

import logging
from collections.abc import Callable, Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap
from ppaas.maps.occupancy import GridMapMessage, GridUpdate, from_message, from_update
from ppaas.messages.base.map_msgs import OccupancyGridUpdate
from ppaas.messages.nav_msgs import OccupancyGrid
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Payload, Timer, Topic
from ppaas.nodes.jobs import LongWork

logger = logging.getLogger(__name__)

PERIOD = 0.9
"""Least time between two builds of the layers [s]. Changes of a map come once a second."""

POLL = 0.1
"""Time for which the parts of one change are collected [s]."""

MARGIN = 2.0
"""Unknown space around a goal outside the map, through which paths may lead [m]."""

MOST_ADDED = 1 << 22
"""Largest map after it is extended to goals, unless it is larger itself [cells]: 102 m x 102 m at 0.05 m."""

Build = Callable[[GridMap], MapLayers]
MapMessage = GridMapMessage | OccupancyGrid | GridUpdate | OccupancyGridUpdate


class _Built(NamedTuple):
    """Map by the messages so far, and its layers; None if there is none, or it has not changed."""

    grid: GridMap | None
    layers: MapLayers | None


class StaticLayer:
    """Keeps the map of the topics, and builds its layers in jobs, at most once in `PERIOD`.

    The map is extended by unknown space to goals outside it, since a map that grows may come to cover them.

    Parameters
    ----------
    context : Context
        Context of the node that subscribes to the topics.
    build : callable
        Returns the layers of a grid.
    use : callable
        Called with new layers, in the thread of the node.
    goals : callable
        Returns the poses to which the map is extended.

    Attributes
    ----------
    has_map : bool
        Whether a map was received.
    began : float
        When the last build began, which contains all messages before [s].
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (topics.MAP, topics.MAP_UPDATES)

    def __init__(
        self,
        context: Context,
        build: Build,
        use: Callable[[MapLayers], None],
        goals: Callable[[], Sequence[Pose2D]],
    ) -> None:
        self.has_map, self.began = False, float("-inf")
        self._context, self._build, self._use, self._goals = context, build, use, goals
        self._grid: GridMap | None = None
        self._info: GridInfo | None = None
        self._layers: MapLayers | None = None
        self._messages: list[MapMessage] = []
        self._running, self._forgotten, self._expects = False, 0, False
        self._next = float("-inf")
        self._timer: Timer | None = None

    def take(self, message: Payload) -> bool:
        """Take a message of one of the topics; return whether it is of one."""
        if not isinstance(message, GridMapMessage | OccupancyGrid | GridUpdate | OccupancyGridUpdate):
            return False
        if isinstance(message, GridMapMessage | OccupancyGrid):
            self._messages.clear()
        self._messages.append(message)
        self._wake()
        return True

    def forget(self) -> None:
        """Forget the map, which was cleared; goals wait for the next one."""
        self.has_map, self._grid, self._layers, self._messages = False, None, None, []
        self._forgotten += 1

    def expect(self) -> None:
        """Build the layers again at once: the map is in another frame, in which what was built before is wrong."""
        self._layers, self._expects, self._next = None, True, float("-inf")
        self._forgotten += 1
        self._wake()

    def waits(self) -> str:
        """Return why the robot cannot drive to its goals yet; empty if it can."""
        if self._expects:
            return "the map is in another frame from now on, and is being prepared"
        if not self.has_map or self._layers is None or self._grid is None:
            return "no map yet: no message has come on 'map'"
        info = self._layers.grid.info
        wanted = covering(self._grid.info, self._goals())
        if not _covers(info, wanted):
            self._wake()
            return "the map is being extended to the goal"
        return ""

    # -- jobs ----------------------------------------------------------------------------------------------------------

    def _wake(self) -> None:
        if self._timer is None:
            self._timer = self._context.every(POLL, self._poll)

    def _poll(self) -> None:
        """Start a build if one is due; sleep if there is nothing to do."""
        if self._running or self._context.elapsed() < self._next:
            return
        if not self._is_behind():
            assert self._timer is not None
            self._timer.stop()
            self._timer = None
            return
        self._running, self.began = True, self._context.elapsed()
        self._next = self.began + PERIOD
        messages, grid, goals, last = tuple(self._messages), self._grid, tuple(self._goals()), self._layers
        forgotten = self._forgotten

        def work(_cancelled: Callable[[], bool]) -> _Built:
            return self._built(applied(grid, messages), goals, last)

        def done(built: _Built | PPaaSError) -> None:
            self._running = False
            if forgotten != self._forgotten:
                return
            taken = set(map(id, messages))
            self._messages = [message for message in self._messages if id(message) not in taken]
            if isinstance(built, PPaaSError):
                logger.warning("the map is left as it is: %s", built)
            else:
                self._take_built(built)

        self._context.start(LongWork(work), done)

    def _is_behind(self) -> bool:
        if self._messages or self._expects:
            return True
        if self._grid is None or self._layers is None:
            return False
        return covering(self._grid.info, self._goals()) != self._layers.grid.info

    def _built(self, grid: GridMap | None, goals: Sequence[Pose2D], last: MapLayers | None) -> _Built:
        """Return a map, and its layers unless they are the last map's."""
        if grid is None:
            return _Built(None, None)
        shown = extended(grid, covering(grid.info, goals))
        same = last is not None and last.grid.info == shown.info and np.array_equal(last.grid.data, shown.data)
        return _Built(grid, None if same else self._build(shown))

    def _take_built(self, built: _Built) -> None:
        self._grid = built.grid
        self._expects = False
        if built.layers is not None:
            self.has_map, self._layers = True, built.layers
            self._use(built.layers)


def applied(grid: GridMap | None, messages: Sequence[MapMessage]) -> GridMap | None:
    """Return a map after messages; those that are not valid are logged, and left out.

    Updates before the first map have no effect. The grid itself is not modified.
    """
    fresh = False
    for message in messages:
        try:
            if isinstance(message, GridMapMessage | OccupancyGrid):
                grid = message.grid if isinstance(message, GridMapMessage) else from_message(message)
                fresh = False
            elif grid is not None:
                if not fresh:
                    grid, fresh = GridMap(grid.data.copy(), grid.info), True
                _overwrite(grid, message)
        except PPaaSError as error:
            logger.warning("a change of the map is left out: %s", error)
    return grid


def _overwrite(grid: GridMap, message: GridUpdate | OccupancyGridUpdate) -> None:
    if isinstance(message, GridUpdate):
        row, column, cells = message.row, message.column, message.cells
    else:
        row, column, cells = from_update(message)
    height, width = cells.shape
    if row < 0 or column < 0 or row + height > grid.info.height or column + width > grid.info.width:
        raise InvalidInput(
            f"an update of {width} x {height} cells from column {column}, row {row} is not within the map of "
            f"{grid.info.width} x {grid.info.height} cells: send the whole map after its size has changed"
        )
    grid.data[row : row + height, column : column + width] = cells


def covering(info: GridInfo, poses: Sequence[Pose2D]) -> GridInfo:
    """Return the geometry of a grid that is extended to poses outside it, except those that are too far away."""
    low, high = np.zeros(2, np.int64), np.array(info.shape)
    margin = round(MARGIN / info.resolution)
    most = max(MOST_ADDED, info.width * info.height)
    for cell in (info.to_cells(pose[:2]) for pose in poses if info.cell_of(pose.x, pose.y) is None):
        lower, upper = np.minimum(low, cell - margin), np.maximum(high, cell + margin + 1)
        if np.prod((upper - lower).astype(np.float64)) <= most:
            low, high = lower, upper
    (row, column), (height, width) = low.tolist(), (high - low).tolist()
    if not (row or column) and (height, width) == info.shape:
        return info
    corner = info.origin @ Pose2D(column * info.resolution, row * info.resolution)
    return GridInfo(info.resolution, width, height, Pose2D(corner.x, corner.y, info.origin.theta))


def extended(grid: GridMap, info: GridInfo) -> GridMap:
    """Return a grid with the larger geometry of `covering`, unknown where it was extended."""
    if info == grid.info:
        return grid
    shift = grid.info.shift_to(info)
    assert shift is not None, "the cells of both grids coincide"
    data = np.full(info.shape, UNKNOWN, np.int8)
    data[shift[0] : shift[0] + grid.info.height, shift[1] : shift[1] + grid.info.width] = grid.data
    return GridMap(data, info)


def _covers(info: GridInfo, wanted: GridInfo) -> bool:
    """Return whether a grid covers all cells of another, whose cells coincide with its own."""
    shift = wanted.shift_to(info)
    if shift is None:
        return False
    row, column = shift
    inside = row >= 0 and column >= 0
    return inside and row + wanted.height <= info.height and column + wanted.width <= info.width
