"""Node ``move_base`` of a robot that drives as far as the traffic of its map grants."""

from dataclasses import replace
from typing import Any, ClassVar

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.fleet.traffic import MapPoint, TrafficGrants
from ppaas.navigation import events
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Payload, Topic
from ppaas.nodes.granted_move_base.grant_follower import GrantFollower
from ppaas.nodes.granted_move_base.granted_planner import GrantedPlanner
from ppaas.nodes.granted_move_base.traffic_link import TrafficLink, Wanted
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.move_base.robot_planner import RobotPlanner

PERIOD = 0.1
"""Time between two looks at the granted way [s]."""

STANDING, TURNING = 0.02, 0.05
"""Speeds below which a robot stands [m/s, rad/s]."""

GIVING_WAY = "traffic/give_way-"
"""Beginning of the ids of goals by which a robot without a goal gives way to others."""

GAVE_WAY = "The robot has given way."

OCCUPIED = 2.0
"""Time for which something must be in a cell ahead before it is reported [s]."""


class GrantedMoveBaseNode(MoveBaseNode):
    """Move Base that drives along the way that the traffic node of the map grants, as far as it is granted.

    The end of the way is where the robot stops, and moves on as more is granted. A robot that is alone on its map is
    notified and drives freely, as any robot does. One without a goal gives way to others. One that has left its way
    stops at once, reports to the traffic node, and is led back.

    Parameters
    ----------
    context : Context
        The node's context.
    link : TrafficLink
        The robot's end of the traffic.
    controller : GrantFollower
    options
        As of `MoveBaseNode`.
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (*MoveBaseNode.subscribes, topics.TRAFFIC_GRANTS)
    publishes: ClassVar[tuple[Topic, ...]] = (*MoveBaseNode.publishes, topics.TRAFFIC_REPORT)

    def __init__(self, context: Context, *, link: TrafficLink, controller: GrantFollower, **options: Any) -> None:
        self._link = link
        super().__init__(context, controller=controller, **options)
        self._surroundings.trust_grants()
        self._given_way = 0
        self._occupied_since: dict[tuple[float, float], float] = {}

    def _make_planner(self, *arguments: Any, **options: Any) -> RobotPlanner:
        return GrantedPlanner(self._link, *arguments, **options)

    def start(self) -> None:
        """Begin to report, in addition to what any Move Base does."""
        super().start()
        self.context.every(PERIOD, self._attend)

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message; raises as Move Base's method does."""
        if isinstance(message, TrafficGrants):
            if self._link.take(message):
                self._attend()
                self._plan_due()
        else:
            super().on_message(topic, message)

    def _feed(self, event: events.Event) -> None:
        super()._feed(event)
        active, wanted = self._machine.goals.active, self._link.wanted
        if active is None or self._gives_way:
            self._link.wanted = None
        elif wanted is None or wanted.id != active.goal.id:
            self._link.wanted = Wanted(active.goal.id, active.goal.pose, self.context.elapsed())
        elif wanted.pose != active.goal.pose:
            self._link.wanted = replace(wanted, pose=active.goal.pose)

    def _plan_due(self) -> None:
        self._feed(events.PlanDue(self.context.elapsed()))

    # -- the way -------------------------------------------------------------------------------------------------------

    def _attend(self) -> None:
        """Compare the robot's pose with its way, do what the traffic node asks, and report."""
        now, link = self.context.elapsed(), self._link
        try:
            pose = self._surroundings.pose(now)
        except PPaaSError:
            return  # nothing can be reported for a robot whose pose is not known
        changed = link.see(pose)
        if link.must_stop:
            self._give_back(now)
        elif self._machine.goals.active is None and link.has_to_move:
            self._give_way(pose, now)
        elif self._gives_way and not link.has_to_move:
            self._feed(events.Preempted(now, GAVE_WAY))
        link.find_blocked(self._occupied(now))
        link.report()
        if changed or (not link.way.ahead and not link.way.free and not link.path_is_final):
            self._plan_due()

    @property
    def _gives_way(self) -> bool:
        active = self._machine.goals.active
        return active is not None and active.goal.id.startswith(GIVING_WAY)

    @property
    def _stands(self) -> bool:
        velocity = self._surroundings.velocity
        return abs(velocity.linear) < STANDING and abs(velocity.angular) < TURNING

    def _give_back(self, now: float) -> None:
        """Stop; once the robot stands, give back the rest of its way."""
        self._feed(events.PlanBlocked(now))
        if self._stands:
            self._link.give_back()

    def _give_way(self, pose: Pose2D, now: float) -> None:
        """Drive where a robot without a goal is granted cells; give back what is left of the way to a goal."""
        grants = self._link.way.grants
        if grants is None or grants.goal_id:
            if self._stands:
                self._link.give_back()
            return
        self._given_way += 1
        x, y = self._link.way.last
        goal = events.Goal(f"{GIVING_WAY}{self._given_way}", Pose2D(x, y, pose.theta), self.context.now())
        self._feed(events.GoalReceived(now, goal))

    def _occupied(self, now: float) -> tuple[MapPoint, ...]:
        """Return the centres of cells ahead in which the robot has seen something for some time."""
        costs, way = self._surroundings.costs, self._link.way
        if costs is None or not way.ahead:
            self._occupied_since = {}
            return ()
        seen: dict[tuple[float, float], float] = {}
        for point in way.held[-way.ahead :]:
            cell = costs.info.cell_of(point.x, point.y)
            cost = NO_INFORMATION if cell is None else int(costs.data[cell])
            if INSCRIBED_INFLATED_OBSTACLE <= cost < NO_INFORMATION:
                seen[point.x, point.y] = self._occupied_since.get((point.x, point.y), now)
        self._occupied_since = seen
        return tuple(MapPoint(*point) for point, since in seen.items() if now - since >= OCCUPIED)
