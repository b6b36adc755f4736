"""Executes the orders of Move Base's state machine, feeds back results, and publishes the local plan."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from ppaas.controllers.base import Controller, ControlRequest, PathGivenUp, Velocity
from ppaas.controllers.motion import advance
from ppaas.errors import PPaaSError, TransformError, Unavailable
from ppaas.geometry import Pose2D, quaternion_of
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.nav_msgs import Path
from ppaas.navigation import events, move_base
from ppaas.navigation.action_goals import GoalList
from ppaas.navigation.passive_safety import PassiveSafety
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP
from ppaas.nodes.move_base.client_paths import rows_of
from ppaas.nodes.move_base.goal_progress import ActionTopics, GoalProgress
from ppaas.nodes.move_base.robot_planner import Detour, NoPlan, Outdated, Planned, RobotPlanner, Waiting
from ppaas.nodes.move_base.speed_limits import SpeedLimits
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.nodes.topics import CMD_VEL, LOCAL_PLAN, PLAN
from ppaas.planners.base import PlanResult
from ppaas.planners.path_json import path_message
from ppaas.recoveries.base import Recovery, RecoveryRequest
from ppaas.thread_budget import Threads

# -- the local plan ----------------------------------------------------------------------------------------------------

AHEAD = 1.7
"""Time that the path covers, ``sim_time`` of dwa_local_planner [s]."""

STEPS = 17
"""Number of poses after the first."""


def publish_local_plan(context: Context, pose: Pose2D, velocity: Velocity) -> None:
    """Publish the arc of a velocity from a pose in the frame of the map, if anybody subscribes to it."""
    if context.has_subscribers(LOCAL_PLAN.name):
        context.publish(LOCAL_PLAN.name, local_plan(pose, velocity, context.now()))


def local_plan(pose: Pose2D, velocity: Velocity, now: float) -> Path:
    """Return the path of a robot that keeps a velocity, stamped ``now`` [s since the epoch]."""
    arc = [advance(pose, velocity, AHEAD * step / STEPS) for step in range(STEPS + 1)]
    rows = np.array([(at.x, at.y, 0.0, *quaternion_of(at.theta)) for at in arc])
    return path_message(rows, Header(stamp=Time.of(now), frame_id=MAP))


# -- execution of the orders of Move Base's state machine --------------------------------------------------------------


class OrderExecutor:
    """Plans, drives and recovers as ordered, and publishes status, feedback and results.

    Parameters
    ----------
    context : Context
        The node's context.
    feed : callable
        Passes an event to the state machine.
    goals : GoalList
        Goals of the state machine.
    surroundings : Surroundings
        Pose, sensors and local costmap of the robot.
    planner, controller
        Plug-ins for plans and velocities.
    recoveries : sequence of Recovery
        Recovery behaviours in the order of the state machine.
    topics : ActionTopics
    limits : SpeedLimits
        Current speed limits.
    passive_safety : PassiveSafety
        Slows the robot down in front of approaching people.
    period : float
        Period of the control cycle [s].
    threads : callable
        Returns the largest number of threads that kernels may use now.

    Attributes
    ----------
    progress : GoalProgress
        Progress to the active goal, from the parameter of that name.
    sent : Velocity
        The last velocity published.
    held : str
        Why the robot is stopped; empty if it is not.
    by_hand : str
        Who drives the robot by hand, in words; empty if nobody does. Goals wait, and send no velocity.
    """

    def __init__(
        self,
        context: Context,
        feed: Callable[[events.Event], None],
        goals: GoalList[events.Goal],
        *,
        surroundings: Surroundings,
        planner: RobotPlanner,
        controller: Controller,
        recoveries: Sequence[Recovery],
        topics: ActionTopics,
        limits: SpeedLimits,
        passive_safety: PassiveSafety,
        period: float,
        threads: Threads,
        progress: GoalProgress,
    ) -> None:
        self.sent = Velocity()
        self.held = self.by_hand = ""
        self._context = context
        self._feed = feed
        self._goals = goals
        self._surroundings = surroundings
        self._planner = planner
        self._controller = controller
        self._recoveries = recoveries
        self._topics = topics
        self._limits = limits
        self._passive_safety = passive_safety
        self._period = period
        self._threads = threads
        self.progress = progress

    @property
    def controller_name(self) -> str:
        """Name of the local planner."""
        return self._controller.name

    def execute(self, order: move_base.Order) -> None:
        """Execute one order."""
        match order:
            case move_base.RequestPlan():
                self._request_plan(order)
            case move_base.CancelPlan():
                self._planner.cancel()
            case move_base.FollowPlan():
                self._follow(order)
            case move_base.ComputeVelocity():
                self._feed(self._compute_velocity(order.pose))
            case move_base.SendVelocity():
                self.send(order.velocity)
            case move_base.StopBase():
                self.send(Velocity())
            case move_base.Recover():
                self._feed(self._recover(order))
            case _:
                self._publish(order)

    def _publish(self, order: move_base.Order) -> None:
        active = self._goals.active
        match order:
            case move_base.PublishGoal():
                if order.updated:
                    self.progress.aim(order.goal.pose)
                else:
                    self.progress.begin(order.goal.pose, self._context.elapsed())
                self._topics.current_goal(order.goal)
            case move_base.PublishStatus():
                self._topics.status(self._goals)
            case move_base.PublishFeedback():
                self._feed_back(order, active.text if active else "")
            case move_base.PublishResult():
                self._topics.result(order.goal, order.status, order.text, order.cause)

    def _feed_back(self, order: move_base.PublishFeedback, text: str) -> None:
        self._topics.feedback(order.goal, order.pose, text)
        self.progress.update(order.pose, self._surroundings.velocity.linear, self._context.elapsed())
        self._topics.progress(order.goal, order.pose, self.progress, order.recoveries)

    def send(self, velocity: Velocity) -> None:
        """Publish a velocity for the base, unless somebody drives it by hand."""
        if not self.by_hand:
            self.send_by_hand(velocity)

    def send_by_hand(self, velocity: Velocity) -> None:
        """Publish a velocity for the base; while the robot is stopped, none but zero."""
        velocity = Velocity() if self.held else velocity
        self.sent = velocity
        self._surroundings.loop.command(self._context.elapsed(), velocity)
        self._context.publish(CMD_VEL.name, Twist(Vector3(x=velocity.linear), Vector3(z=velocity.angular)))

    def check_released(self) -> None:
        """Raise ``Unavailable`` while the robot is stopped, or driven by hand."""
        if why := self.held or self.by_hand:
            raise Unavailable(why)

    def _follow(self, order: move_base.FollowPlan) -> None:
        try:
            active = self._goals.active
            self.progress.follow(order.poses, active.goal.through if active else ())
            self._controller.set_plan(self.progress.ahead)
        except PPaaSError as error:
            self._feed(events.ControlFailed(self._context.elapsed(), str(error)))

    def check_plan(self) -> None:
        """Plan again if the plan that the robot follows is blocked, after the map was replaced."""
        if self.progress.has_plan and self._planner.is_blocked(self.progress.rest):
            self._feed(events.PlanBlocked(self._context.elapsed()))

    def see(self, pose: Pose2D) -> None:
        """Take the pose of the robot, which may pass poses on its way to the goal."""
        self._pass(self.progress.take_passed(pose))

    def _pass(self, count: int) -> bool:
        """Lead the local planner on after a number of poses on the way; return whether there were any."""
        if count:
            self._feed(events.PosesPassed(self._context.elapsed(), count))
            self._controller.set_plan(self.progress.ahead)
        return count > 0

    def _compute_velocity(self, pose: Pose2D) -> events.Event:
        around, costs = self._surroundings, self._surroundings.costs
        assert costs is not None, "a control tick brings the costs up to date"
        movers = around.movers(pose, self._context.elapsed())
        active = self._goals.active
        limit = self._limits.at(pose, active.goal.speed_limit if active else 0.0)
        ahead, moving = around.loop.ahead(self._context.elapsed(), pose, around.velocity, self._controller.known_delay)
        request = ControlRequest(ahead, moving, costs, self._period, self._threads(), movers, limit)
        try:
            reached = self._controller.is_goal_reached(pose, around.velocity) and not self._pass(
                self.progress.take_next()
            )
            velocity = Velocity() if reached else self._controller.compute_velocity(request)
        except PPaaSError as error:
            return events.ControlFailed(self._context.elapsed(), str(error), isinstance(error, PathGivenUp))
        velocity = self._passive_safety.slowed(velocity, pose, around.walkers(pose, self._context.elapsed()))
        publish_local_plan(self._context, pose, velocity)
        return events.VelocityComputed(self._context.elapsed(), velocity, reached)

    def _recover(self, order: move_base.Recover) -> events.Event:
        around, now = self._surroundings, self._context.elapsed()
        assert around.costs is not None, "a control tick brings the costs up to date"
        recovery = self._recoveries[order.index]
        request = RecoveryRequest(now, order.pose, around.costs, around.clear, around.fits)
        try:
            if order.begin:
                recovery.start(request)
            velocity = recovery.step(request)
        except PPaaSError as error:
            return events.RecoveryEnded(now, str(error))
        return events.RecoveryEnded(now) if velocity is None else events.RecoveryStepped(now, velocity)

    def _request_plan(self, order: move_base.RequestPlan) -> None:
        try:
            start = self._surroundings.pose(self._context.elapsed())
        except TransformError as error:
            self._feed(events.PlanFailed(self._context.elapsed(), order.number, error))
            return
        active = self._goals.active
        done = partial(self._on_planned, order)
        if active is not None and active.goal.path:
            given = self.progress.rest if self.progress.has_plan else rows_of(active.goal.path)
            self._planner.along(start, given, done)
            return
        with self._topics.traces.of(None if active is None else active.goal):
            self._planner.request(start, order.goal, done, order.through)

    def _on_planned(self, order: move_base.RequestPlan, result: Planned) -> None:
        now, number = self._context.elapsed(), order.number
        match result:
            case Outdated():
                self._request_plan(order)
            case Detour() | Waiting():
                self._feed(events.PlanDeferred(now, number, result.reason))
            case PlanResult():
                self._feed(events.PlanSucceeded(now, number, result.poses, result.origin))
                self._context.publish(PLAN.name, result)
            case NoPlan():
                self._feed(events.PlanFailed(now, number, result.error, result.final))
            case _:
                self._feed(events.PlanFailed(now, number, result))
