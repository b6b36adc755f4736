"""Nav2's actions ``compute_route`` and ``compute_and_track_route``: routes along the lanes of the map.

Neither moves the robot: as in Nav2, a client drives along the path by another action.
"""

from collections.abc import Callable
from typing import ClassVar

import msgspec

from ppaas.clock import monotonic
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput, NotFound, NoValidPath, PPaaSError, TransformError
from ppaas.fleet.lane_routes import LaneGraph, LanePlace, LaneRoute
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Duration, Header, Time
from ppaas.messages.geometry_msgs import Point
from ppaas.messages.nav2_servers import (
    ComputeAndTrackRouteActionGoal,
    ComputeAndTrackRouteFeedback,
    ComputeAndTrackRouteResult,
    ComputeRouteActionGoal,
    ComputeRouteGoal,
    ComputeRouteResult,
    Route,
    RouteEdge,
    RouteError,
    RouteNode,
)
from ppaas.messages.nav_msgs import Path
from ppaas.navigation.action_goals import GoalList, cancels
from ppaas.navigation.events import CancelReceived
from ppaas.nodes.action_publisher import ActionPublisher
from ppaas.nodes.base import Context, Payload, Timer, Topic
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import expect, pose_in
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.nodes.nav2_actions import COMPUTE_AND_TRACK_ROUTE, COMPUTE_ROUTE
from ppaas.planners.path_json import path_message

REACHED = 0.5
"""Distance from a node at which it counts as reached, and as passed on the way to the next [m]."""

PERIOD, FEEDBACK_PERIOD = 0.2, 1.0
"""Period of looks at the robot that drives along a route, and longest time between two feedbacks [s]."""


class RouteGoal(msgspec.Struct):
    """Route that the robot is watched on; checkpoints contain it as JSON.

    Parameters
    ----------
    id, stamp
        As of any action's goal.
    route : LaneRoute
    start, goal : Pose2D, optional
        Poses before and behind it; None without ``use_poses``.
    reached : int
        Number of nodes that the robot has reached.
    seconds : float
        Time for which it was watched before this executor [s].
    """

    id: str
    stamp: float
    route: LaneRoute = LaneRoute((), ())
    start: Pose2D | None = None
    goal: Pose2D | None = None
    reached: int = 0
    seconds: float = 0.0


class RouteActions:
    """Serves both actions; a goal of the second replaces the one before, as in Nav2.

    Parameters
    ----------
    context : Context
        Context of the node that serves them.
    surroundings : Surroundings
        Pose and frames of the robot, and the zones of its map.
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (*COMPUTE_ROUTE[:2], *COMPUTE_AND_TRACK_ROUTE[:2])
    publishes: ClassVar[tuple[Topic, ...]] = (*COMPUTE_ROUTE[2:], *COMPUTE_AND_TRACK_ROUTE[2:])

    def __init__(self, context: Context, surroundings: Surroundings) -> None:
        self._context, self._surroundings = context, surroundings
        self._computed: GoalList[RouteGoal] = GoalList()
        self._tracked: GoalList[RouteGoal] = GoalList()
        self._computing: ActionPublisher[RouteGoal] = ActionPublisher(context, COMPUTE_ROUTE)
        self._tracking: ActionPublisher[RouteGoal] = ActionPublisher(context, COMPUTE_AND_TRACK_ROUTE)
        self._graph: tuple[MapLayers, LaneGraph] | None = None
        self._timer: Timer | None = None
        self._began = self._said = 0.0
        self._counter = 0
        self._handlers: dict[str, Callable[[Payload], None]] = {
            COMPUTE_ROUTE.goal.name: self._on_compute,
            COMPUTE_AND_TRACK_ROUTE.goal.name: self._on_track,
            COMPUTE_ROUTE.cancel.name: lambda _: None,  # a route is computed at once
            COMPUTE_AND_TRACK_ROUTE.cancel.name: self._on_cancel,
        }

    def take(self, topic: str, message: Payload) -> bool:
        """Handle a message of one of the topics; return whether it is of one."""
        handle = self._handlers.get(topic)
        if handle is not None:
            handle(message)
        return handle is not None

    def publish_statuses(self) -> None:
        """Publish the statuses of all goals."""
        self._computing.status(self._computed)
        self._tracking.status(self._tracked)

    # -- compute_route -------------------------------------------------------------------------------------------------

    def _on_compute(self, message: Payload) -> None:
        request = expect(message, ComputeRouteActionGoal)
        goal = self._new(request.goal_id)
        if self._computed.knows(goal.id, self._context.elapsed()):
            return
        self._computed.accept(goal)
        began = monotonic()
        status, text, code = Status.SUCCEEDED, "", RouteError.NONE
        try:
            self._find(goal, request.goal)
        except PPaaSError as error:
            status, text, code = Status.ABORTED, str(error), error_of(error)
        took = Duration.of(monotonic() - began)
        self._computed.end(self._context.elapsed(), status, text)
        result = ComputeRouteResult(took, self._path(goal), self._message(goal.route), int(code), text)
        self._computing.result(goal, status, text, result)
        self._computing.status(self._computed)

    def _new(self, goal_id: GoalID) -> RouteGoal:
        self._counter += 1
        stamp = goal_id.stamp.seconds() or self._context.now()
        return RouteGoal(goal_id.id or f"route-{self._counter}-{stamp:.3f}", stamp)

    def _find(self, goal: RouteGoal, wanted: ComputeRouteGoal) -> None:
        """Find the route of a goal; raises ``PPaaSError`` if there is none."""
        graph = self._lanes()
        if not wanted.use_poses:
            goal.route = graph.route(wanted.start_id, wanted.goal_id)
            return
        around = self._surroundings
        tree = around.frames.tree
        goal.goal = pose_in(tree, MAP, wanted.goal, "the goal")
        if wanted.use_start:
            goal.start = pose_in(tree, MAP, wanted.start, "the start")
        else:
            goal.start = around.pose(self._context.elapsed())
        goal.route = graph.between(goal.start, goal.goal)

    def _lanes(self) -> LaneGraph:
        """Return the graph of the lanes of the map, which is made once for each map; ``InvalidInput`` without lanes."""
        layers = self._surroundings.layers
        if self._graph is None or self._graph[0] is not layers:
            try:
                self._graph = layers, LaneGraph(layers.zones.zones)
            except InvalidInput as error:
                raise NoLanes(str(error)) from error
        return self._graph[1]

    # -- messages ------------------------------------------------------------------------------------------------------

    def _header(self) -> Header:
        return Header(stamp=Time.of(self._context.now()), frame_id=MAP)

    def _path(self, goal: RouteGoal) -> Path:
        if not goal.route.places:
            return Path(self._header(), [])
        return path_message(goal.route.poses(goal.start, goal.goal), self._header())

    def _message(self, route: LaneRoute) -> Route:
        nodes = [RouteNode(place.number, Point(place.x, place.y)) for place in route.places]
        edges = [
            RouteEdge(part, one.position, other.position)
            for part, one, other in zip(route.parts, nodes, nodes[1:], strict=False)
        ]
        return Route(self._header(), route.length if nodes else 0.0, nodes, edges)

    # -- compute_and_track_route ---------------------------------------------------------------------------------------

    def _on_track(self, message: Payload) -> None:
        request = expect(message, ComputeAndTrackRouteActionGoal)
        goal = self._new(request.goal_id)
        if self._tracked.knows(goal.id, self._context.elapsed()):
            return
        self._end(Status.PREEMPTED, f"Replaced by another goal: {goal.id}")
        try:
            self._find(goal, request.goal)
        except PPaaSError as error:
            self._tracked.refuse(goal, self._context.elapsed(), str(error))
            self._publish_end(goal, Status.ABORTED, str(error), error_of(error))
            return
        self._begin(goal)

    def _begin(self, goal: RouteGoal) -> None:
        self._tracked.accept(goal)
        self._began = self._context.elapsed() - goal.seconds
        self._tracking.status(self._tracked)
        self._feed_back(goal)
        self._timer = self._context.every(PERIOD, self._look)

    def _on_cancel(self, message: Payload) -> None:
        cancel, active = expect(message, GoalID), self._tracked.active
        event = CancelReceived(self._context.elapsed(), cancel.id, cancel.stamp.seconds())
        if active is not None and cancels(event, active.goal):
            self._end(Status.PREEMPTED, "The goal was cancelled.")

    def _look(self) -> None:
        """See how far the robot has come along the route."""
        active = self._tracked.active
        if active is None:
            return
        now, goal = self._context.elapsed(), active.goal
        try:
            pose = self._surroundings.pose(now)
        except PPaaSError:
            return  # the robot stands, and will be seen again
        before = goal.reached
        while goal.reached < len(goal.route.places) and _has_reached(goal.route, goal.reached, pose):
            goal.reached += 1
        if goal.reached != before or now - self._said >= FEEDBACK_PERIOD:
            self._feed_back(goal)
        if goal.reached == len(goal.route.places) and (goal.goal is None or pose.distance_to(goal.goal) <= REACHED):
            self._end(Status.SUCCEEDED, "")

    def _feed_back(self, goal: RouteGoal) -> None:
        self._said = self._context.elapsed()
        places, reached = goal.route.places, goal.reached
        last = places[reached - 1].number if reached else 0
        ahead = places[reached].number if reached < len(places) else 0
        edge = goal.route.parts[reached - 1] if 0 < reached < len(places) else 0
        feedback = ComputeAndTrackRouteFeedback(last, ahead, edge, self._message(goal.route), self._path(goal))
        self._tracking.feedback(goal, feedback)

    def _end(self, status: Status, text: str) -> None:
        """End the goal, if there is one."""
        if self._tracked.active is None or self._timer is None:
            return
        self._timer.stop()
        goal = self._tracked.end(self._context.elapsed(), status, text).goal
        goal.seconds = self._context.elapsed() - self._began
        self._publish_end(goal, status, text, RouteError.NONE)

    def _publish_end(self, goal: RouteGoal, status: Status, text: str, code: RouteError) -> None:
        result = ComputeAndTrackRouteResult(Duration.of(goal.seconds), int(code), text if code else "")
        self._tracking.result(goal, status, text, result)
        self._tracking.status(self._tracked)

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> RouteGoal | None:
        """Return the route that the robot is watched on; None if there is none."""
        active = self._tracked.active
        if active is None:
            return None
        return msgspec.structs.replace(active.goal, seconds=self._context.elapsed() - self._began)

    def restore(self, goal: RouteGoal | None) -> None:
        """Watch the robot on."""
        if goal is not None and not self._tracked.knows(goal.id, self._context.elapsed()):
            self._begin(goal)


class NoLanes(InvalidInput):
    """The map has no lanes on which there could be a route."""


def error_of(error: PPaaSError) -> RouteError:
    """Return the ``error_code`` of Nav2 for an error."""
    codes: tuple[tuple[type[PPaaSError], RouteError], ...] = (
        (TransformError, RouteError.TF_ERROR),
        (NoLanes, RouteError.NO_VALID_GRAPH),
        (NotFound, RouteError.INDETERMINANT_NODES_ON_GRAPH),
        (NoValidPath, RouteError.NO_VALID_ROUTE),
    )
    return next((code for kind, code in codes if isinstance(error, kind)), RouteError.UNKNOWN)


def _has_reached(route: LaneRoute, index: int, pose: Pose2D) -> bool:
    """Return whether a robot is at a node of a route, or has passed it towards the next one."""
    place = route.places[index]
    if pose.distance_to(Pose2D(place.x, place.y)) <= REACHED:
        return True
    if index + 1 == len(route.places):
        return False
    return _is_on(pose, place, route.places[index + 1])


def _is_on(pose: Pose2D, begin: LanePlace, end: LanePlace) -> bool:
    """Return whether a robot drives on a part of a lane, within `REACHED` beside it."""
    dx, dy = end.x - begin.x, end.y - begin.y
    squared = max(dx * dx + dy * dy, 1e-12)
    share = ((pose.x - begin.x) * dx + (pose.y - begin.y) * dy) / squared
    off = abs((pose.x - begin.x) * dy - (pose.y - begin.y) * dx) / squared**0.5
    return 0.0 < share <= 1.0 and off <= REACHED
