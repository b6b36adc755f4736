"""Node ``move_base`` of a robot that drives as far as traffic grants, with its global and local planner."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from ppaas.controllers.base import Controller, ControlRequest, Velocity
from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.errors import GoalOccupied, PPaaSError
from ppaas.geometry import Pose2D, Poses, poses_along
from ppaas.messages.base.std_msgs import String
from ppaas.messages.fleet.traffic import MapPoint, TrafficGrants
from ppaas.messages.nav_msgs import Path
from ppaas.navigation import events
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Payload, Topic
from ppaas.nodes.granted_move_base.traffic_link import TrafficLink, Wanted
from ppaas.nodes.message_checks import expect
from ppaas.nodes.move_base.client_paths import poses_of_path
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.nodes.move_base.robot_planner import NoPlan, Planned, RobotPlanner, Waiting
from ppaas.planners.base import PlanResult
from ppaas.traffic.granted_way import STEP, path_along
from ppaas.traffic.room_in_cells import Point

# -- grant follower ----------------------------------------------------------------------------------------------------


class GrantFollower(Controller):
    """Drives by the robot's own local planner while the robot drives freely, and else along the granted way.

    Parameters
    ----------
    link : TrafficLink
    free : Controller
        Local planner of the robot.
    granted : Controller
        Local planner that stays on its path.
    """

    name = "traffic"
    purpose = "Stays on the way that the traffic of the map grants."
    predicts = True

    def __init__(self, link: TrafficLink, free: Controller, granted: Controller) -> None:
        self._link = link
        self._free, self._granted = free, granted
        self._in_use = granted

    def set_plan(self, poses: Poses) -> None:
        """Follow this plan (n, 7) from now on."""
        self._in_use = self._free if self._link.way.free else self._granted
        self._in_use.set_plan(poses)

    def is_goal_reached(self, pose: Pose2D, velocity: Velocity) -> bool:
        """Return whether the robot stands at its goal; the end of what is granted so far is none."""
        final = self._in_use is self._free or self._link.path_is_final
        return final and self._in_use.is_goal_reached(pose, velocity)

    def compute_velocity(self, request: ControlRequest) -> Velocity:
        """Return the velocity for this cycle; none for a robot that has to stop.

        Raises
        ------
        NoValidControl
            Something is in the way: the caller must stop.
        """
        if self._link.must_stop:
            return Velocity()
        return self._in_use.compute_velocity(request)


# -- planner of a robot in traffic -------------------------------------------------------------------------------------

NAME = "traffic"
"""Name of the planner in plans."""


class GrantedPlanner(RobotPlanner):
    """Plans as any robot's planner while the robot drives freely, and else returns the granted way.

    Parameters
    ----------
    link : TrafficLink
    options
        As of `RobotPlanner`.
    """

    def __init__(self, link: TrafficLink, *arguments: object, **options: object) -> None:
        super().__init__(*arguments, **options)  # type: ignore[arg-type]
        self._link = link

    def is_blocked(self, poses: Poses) -> bool:
        """Return whether a plan is blocked now; a granted way is as it is."""
        return self._link.way.free and super().is_blocked(poses)

    def request(
        self, start: Pose2D, goal: Pose2D, done: Callable[[Planned], None], through: Sequence[Pose2D] = ()
    ) -> None:
        """Plan to a goal, or pass on the granted way; ``done`` is called with the result."""
        self._link.path_is_final = False
        if self._link.way.free and not self._link.must_stop:
            super().request(start, goal, done, through)
        else:
            done(self._granted(start, goal))

    def along(self, start: Pose2D, poses: Poses, done: Callable[[Planned], None]) -> None:
        """Follow a path of a client while the robot drives freely; else refuse it."""
        if self._link.way.free and not self._link.must_stop:
            super().along(start, poses, done)
        else:
            reason = "the robot drives along the way that the traffic of its map grants: send a goal, not a path"
            done(NoPlan(GoalOccupied(reason), final=True))

    def _granted(self, start: Pose2D, goal: Pose2D) -> Planned:
        link, way = self._link, self._link.way
        if reason := link.refusal:
            return NoPlan(GoalOccupied(f"the traffic of the map refuses the goal: {reason}"), final=True)
        if link.must_stop or not way.spacing:
            return Waiting(link.waits_for())
        leg, ends = way.leg()
        final = self._final_pose(goal) if ends else None
        if final is None and (not link.has_to_move or len(leg) < 2):
            return Waiting(link.waits_for())
        poses = path_along(leg, way.spacing, start, final)
        link.path_is_final = final is not None
        length = float(np.hypot(*np.diff(poses[:, :2], axis=0).T).sum())
        return PlanResult(np.empty((0, 2), np.int32), poses, 0.0, length, 0, 0.0, NAME)

    def _final_pose(self, goal: Pose2D) -> Pose2D | None:
        """Return where the robot stops at its goal; None on the way there."""
        way = self._link.way
        return way.stop_at(goal, self._is_free) if way.leads_to(self._link.goal_id) else None

    def _is_free(self, begin: Point, end: Point) -> bool:
        """Return whether the robot sees nothing on a straight way."""
        steps = max(math.ceil(math.dist(begin, end) / STEP), 1)
        return not super().is_blocked(poses_along(np.linspace(begin, end, steps + 1)))


# -- the node ----------------------------------------------------------------------------------------------------------

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
    stops at once, reports to the traffic node, and is led back. One that is stopped, or driven by hand, follows no
    grants: it gives back its way, and others are led around the place where it is.

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

    subscribes: ClassVar[tuple[Topic, ...]] = (*MoveBaseNode.subscribes, topics.TRAFFIC_GRANTS, topics.DOCK_WAY)
    publishes: ClassVar[tuple[Topic, ...]] = (
        *MoveBaseNode.publishes, topics.TRAFFIC_REPORT, topics.DOCK_WAY_STATE,
    )  # fmt: skip

    def __init__(self, context: Context, *, link: TrafficLink, controller: GrantFollower, **options: Any) -> None:
        self._link = link
        super().__init__(context, controller=controller, **options)
        self._surroundings.trust_grants(True)
        self._given_way = 0
        self._lacks: str | None = None
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
        elif topic == topics.DOCK_WAY.name:
            points = poses_of_path(expect(message, Path), self._surroundings.frames.tree)
            self._link.approach, self._lacks = [MapPoint(at.x, at.y) for at in points], None
            self._attend()
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
        if self._is_aside():
            link.report()
            if len(link.approach) > 1:
                self._say_approach(link.lacks_approach())
            return
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

    def _is_aside(self) -> bool:
        """Return whether the robot follows no grants; tell the link so, once a robot that was stopped stands."""
        by_hand, held = bool(self._executor.by_hand), bool(self._executor.held or self._docks)
        self._surroundings.trust_grants(not by_hand)
        if by_hand or not held or self._stands:
            self._link.set_aside("by_hand" if by_hand else "held" if held else "")
        return bool(self._link.aside)

    @property
    def _docks(self) -> bool:
        """Whether the robot docks or undocks, or stands at a dock without a goal."""
        return len(self._link.approach) > (0 if self._machine.goals.active is None else 1)

    def _say_approach(self, why: str) -> None:
        """Publish why the robot may not drive on its approach, if that has changed; empty if it may."""
        if why != self._lacks:
            self._lacks = why
            self.context.publish(topics.DOCK_WAY_STATE.name, String(why))

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
