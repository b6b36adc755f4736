"""Publishers of costmaps and of the robot's footprint, for clients that show them.

A topic is published only while it has subscribers, and costmaps become messages outside the node's thread, so that
they do not delay the control cycle. The names come from Nav2 and from ROS 1, where they are below ``move_base``.
"""

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ppaas.costmap.costmap import Costmap, occupancy_of
from ppaas.errors import InvalidInput, PPaaSError
from ppaas.footprints import Footprint, disc_outline
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import to_message
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point32, Polygon, PolygonStamped
from ppaas.messages.nav2_msgs import ClearEntireCostmapRequest, ClearEntireCostmapResponse
from ppaas.messages.nav_msgs import OccupancyGrid
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Topic
from ppaas.nodes.frames import MAP
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.recoveries.base import AffectedMaps
from ppaas.robot_model.known_models import RobotModel

GLOBAL_PERIOD = 1.0
"""Least time between two global costmaps [s]."""

REPEAT_PERIOD = 10.0
"""Time after which a global costmap is sent again although it has not changed, in case that it was lost [s]."""

EARLY = 1e-6
"""Time by which a timer may be early [s]."""

GLOBAL = (topics.GLOBAL_COSTMAP, topics.MOVE_BASE_GLOBAL_COSTMAP)
LOCAL = (topics.LOCAL_COSTMAP, topics.MOVE_BASE_LOCAL_COSTMAP)
FOOTPRINT = (topics.LOCAL_FOOTPRINT, topics.MOVE_BASE_FOOTPRINT)
PUBLISHED = (*GLOBAL, *LOCAL, *FOOTPRINT)
"""Topics that `CostmapTopics` publishes."""

CLEARED: dict[str, AffectedMaps] = {
    "move_base/clear_costmaps": "both",
    "global_costmap/clear_entirely_global_costmap": "global",
    "local_costmap/clear_entirely_local_costmap": "local",
}
"""Services that clear observed obstacles, and where."""

OBSTACLE_LAYERS = ("obstacle_layer", "voxel_layer")
"""Names of the layers that hold observed obstacles in the parameters of Nav2 and costmap_2d."""


def answer_to_clear(request: Message) -> Message:
    """Return the answer to a request to clear a costmap.

    Raises
    ------
    InvalidInput
        It names a layer that holds no observed obstacles.
    """
    if not isinstance(request, ClearEntireCostmapRequest):
        return Empty()
    if unknown := sorted(set(request.plugins) - set(OBSTACLE_LAYERS)):
        raise InvalidInput(
            f"plugins: no obstacles are observed in {', '.join(map(repr, unknown))}; "
            f"name {' or '.join(OBSTACLE_LAYERS)}, or none for all layers"
        )
    return ClearEntireCostmapResponse()


class RenderedCostmap(NamedTuple):
    """A costmap as a grid, and the message of that."""

    grid: GridMap
    message: OccupancyGrid


class LatchedTopics:
    """Topics with the same messages, published while they have subscribers; later ones get the last message.

    Parameters
    ----------
    context : Context
        The node's context.
    names : sequence of Topic
        The topics.
    period : float
        Least time between two messages [s]; infinite for topics that are never published.
    """

    def __init__(self, context: Context, names: Sequence[Topic], period: float) -> None:
        self._context = context
        self._names = [topic.name for topic in names]
        self._period = period
        self._next = -math.inf if math.isfinite(period) else math.inf
        self._up_to_date: set[str] = set()

    @property
    def has_last(self) -> bool:
        """True if a topic with subscribers has a last message."""
        return bool(self._up_to_date)

    def is_due(self, now: float) -> bool:
        """Return whether a message is due; last messages of topics without subscribers are dropped as out of date."""
        heard = {name for name in self._names if self._context.has_subscribers(name)}
        for name in self._up_to_date - heard:
            self._context.forget(name)
        self._up_to_date &= heard
        if not heard or now < self._next:
            return False
        self._next = now + self._period - EARLY
        return True

    def publish(self, message: Message, *, again: bool = True) -> None:
        """Publish a message on the topics with subscribers; without ``again``, only on those that do not have it."""
        for name in self._names:
            if self._context.has_subscribers(name) and (again or name not in self._up_to_date):
                self._context.publish(name, message)
                self._up_to_date.add(name)


class GridTopics(LatchedTopics):
    """Topics of a costmap, which is converted outside the node's thread.

    Parameters
    ----------
    context : Context
    names : sequence of Topic
    period : float
    repeat_period : float
        Time for which a costmap that has not changed is not published again [s].
    """

    def __init__(self, context: Context, names: Sequence[Topic], period: float, repeat_period: float = 0.0) -> None:
        super().__init__(context, names, period)
        self._repeat_period = repeat_period
        self._last: RenderedCostmap | None = None
        self._sent_at = -math.inf
        self._rendering = False

    def is_due(self, now: float) -> bool:
        """Return whether a costmap is due, which it is not while the last one is being converted."""
        return not self._rendering and super().is_due(now)

    def show(self, costmap: Costmap, now: float) -> None:
        """Publish a costmap once it is converted."""
        self._rendering = True
        stamp = Time.of(self._context.now())
        last = self._last if self.has_last and now - self._sent_at < self._repeat_period else None
        self._context.start(lambda _cancelled: _render(costmap, stamp, last), partial(self._on_rendered, last, now))

    def _on_rendered(self, last: RenderedCostmap | None, now: float, rendered: RenderedCostmap | PPaaSError) -> None:
        self._rendering = False
        if isinstance(rendered, PPaaSError):
            return
        if rendered is not last:
            self._sent_at = now
        self._last = rendered if self._repeat_period else None
        self.publish(rendered.message, again=rendered is not last)


class CostmapTopics:
    """Publishes the global costmap when it has changed, and the local one and the footprint periodically.

    Parameters
    ----------
    context : Context
        The node's context.
    surroundings : Surroundings
        Pose of the robot, local costmap and obstacle memory.
    body : RobotModel
        Outline or radius of the robot.
    publish_frequency : float
        Rate of the local costmap and of the footprint [Hz]; 0 for neither.

    Attributes
    ----------
    period : float
        Time between two calls of `publish` [s].
    """

    def __init__(
        self,
        context: Context,
        surroundings: Surroundings,
        *,
        body: RobotModel,
        publish_frequency: float,
    ) -> None:
        self._context = context
        self._around = surroundings
        self._outline = body.footprint or disc_outline(body.robot_radius)
        period = 1.0 / publish_frequency if publish_frequency else math.inf
        self.period = min(GLOBAL_PERIOD, period)
        self._global = GridTopics(context, GLOBAL, GLOBAL_PERIOD, REPEAT_PERIOD)
        self._local = GridTopics(context, LOCAL, period)
        self._footprint = LatchedTopics(context, FOOTPRINT, period)

    def publish(self) -> None:
        """Publish what is due and has subscribers."""
        now = self._context.elapsed()
        due = [each for each in (self._footprint, self._local, self._global) if each.is_due(now)]
        pose = self._look(now) if due else None
        if pose is not None and self._footprint in due:
            header = Header(stamp=Time.of(self._context.now()), frame_id=MAP)
            self._footprint.publish(PolygonStamped(header, _at(pose, self._outline)))
        costs = self._around.costs
        if pose is not None and costs is not None and self._local in due:
            self._local.show(costs, now)
        if self._global in due:
            self._global.show(self._around.seen(), now)

    def _look(self, now: float) -> Pose2D | None:
        """Bring the local costmap up to date, and return the pose of the robot; None while it is unknown."""
        try:
            pose = self._around.pose(now)
            self._around.look_around(pose, now)
        except PPaaSError:
            return None
        return pose


def _render(costmap: Costmap, stamp: Time, last: RenderedCostmap | None) -> RenderedCostmap:
    """Return a costmap as a grid and its message; the last one if it is the same."""
    grid = occupancy_of(costmap)
    if last is not None and last.grid.info == grid.info and np.array_equal(last.grid.data, grid.data):
        return last
    return RenderedCostmap(grid, to_message(grid, MAP, stamp))


def _at(pose: Pose2D, outline: Footprint) -> Polygon:
    """Return an outline of the robot in the frame of the map."""
    corners = [pose @ Pose2D(x, y) for x, y in outline]
    return Polygon([Point32(corner.x, corner.y) for corner in corners])
