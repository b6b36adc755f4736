"""Node ``move_base``: feeds events to the state machine of Move Base, and executes its orders."""

import contextlib
import logging
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import msgspec

from ppaas.controllers.base import Controller
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.map_layers import MapLayers, unchanged
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages import nav2_msgs
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import String
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.health.stops import StopState
from ppaas.messages.move_base_msgs import MoveBaseActionGoal
from ppaas.messages.nav2_motions import FollowPathActionGoal
from ppaas.messages.nav_msgs import GetPlan, Odometry
from ppaas.messages.people_coordination import GoalUpdate, PeopleState
from ppaas.messages.people_msgs import People
from ppaas.messages.ppaas_msgs import ComputePath, RobotStates
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.std_srvs import EmptyService
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.navigation import events
from ppaas.navigation.move_base import MoveBase
from ppaas.navigation.parameters import MoveBaseParameters
from ppaas.navigation.passive_safety import PassiveSafety
from ppaas.navigation.progress_checker import ProgressChecker
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Demands, Node, Payload, Reply, Service, Timer, Topic
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import pose_in
from ppaas.nodes.move_base.behaviors import Behaviors, BehaviorState
from ppaas.nodes.move_base.client_paths import check_controller, error_of, path_to_follow
from ppaas.nodes.move_base.costmap_topics import CLEARED, PUBLISHED, CostmapTopics, answer_to_clear
from ppaas.nodes.move_base.goal_progress import ActionTopics, GoalProgress
from ppaas.nodes.move_base.object_following import PREFIX as OBJECT_GOAL
from ppaas.nodes.move_base.object_following import ObjectFollower, ObjectGoal
from ppaas.nodes.move_base.order_executor import OrderExecutor
from ppaas.nodes.move_base.path_actions import PathGoal, RobotPaths
from ppaas.nodes.move_base.robot_planner import RobotPlanner
from ppaas.nodes.move_base.route_actions import RouteGoal
from ppaas.nodes.move_base.speed_limits import LimitsByPlace, SpeedLimits, without_limits
from ppaas.nodes.move_base.static_layer import Build, StaticLayer
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.nodes.move_base.teleop import Teleop
from ppaas.nodes.move_base.through_goals import GAVE_WAY, gives_way, is_update_of, limit_of_goal, poses_of, update_of
from ppaas.nodes.nav2_actions import FOLLOW_PATH, NAVIGATE_THROUGH_POSES
from ppaas.planners.base import Planner
from ppaas.plans.reuse.processor import PlanProcessor
from ppaas.recoveries.base import Recovery
from ppaas.thread_budget import Threads

logger = logging.getLogger(__name__)

Processors = Callable[[Costmap, str | None], PlanProcessor]
"""Called with the costmap of a map alone and its version, None if it is not published; returns what plans on it."""

STATUS_PERIOD = 1.0


ON_OTHER_MAP = "the robot is on another map now; goals on the map before have ended"


class MoveBaseState(msgspec.Struct):
    """Checkpoint of Move Base: the active goal and for how long [s], the last speed limit, and other actions.

    Who drives by hand, in words, is part of it, since the goal of a robot that moves with somebody's hand on it ends.
    """

    goal: events.Goal | None
    counter: int
    speed_limit: float = 0.0
    percentage: bool = False
    seconds: float = 0.0
    paths: tuple[PathGoal, ...] = ()
    behavior: BehaviorState | None = None
    by_hand: str = ""
    route: RouteGoal | None = None
    object: ObjectGoal | None = None


class MoveBaseNode(Node):
    """Drives the robot to goals, with the topics, services and parameters of ROS's move_base.

    Planner and controller work in the map frame: one frame for the plan, the costmap and the other robots. In return,
    the robot's pose jumps by a few centimetres whenever localization corrects it.

    Parameters
    ----------
    context : Context
        The node's context.
    surroundings : Surroundings
        Pose, sensors and local costmap of the robot, and its map.
    planner, controller
        Plug-ins for the robot's own plans and velocities.
    path_planners : dict of str to Planner
        Planners with their own parameters by name, including another instance of ``planner``, for the path services:
        a service call must not block the robot's own planner.
    recoveries : sequence of (str, Recovery)
        Recovery behaviours in order, each with its name in status texts.
    parameters : MoveBaseParameters
        Named as in move_base.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    processors : callable
        Returns the processor that finds stored plans for the costmap of the map alone and its version; none are used or
        stored for a map without a version.
    version : str, optional
        Version of the map; None if it is not published.
    passive_safety : PassiveSafety
        Slows the robot down in front of approaching people.
    teleop : callable
        Makes the part by which operators drive by hand.
    costmap_topics : CostmapTopics
        Publishes costmaps and the footprint.
    top_speed : float
        Fastest speed of the robot, with which the remaining time is estimated at first [m/s].
    limits_by_place : callable, optional
        Returns the speed limits by place for the layers of a map, and for a function that returns the time [s].
    adapt : callable, optional
        Returns the layers for this robot from the layers of a map that replaces another.
    build : callable, optional
        Returns the layers of a grid. With it, the map comes from topics, see `MappingMoveBaseNode`.
    """

    name: ClassVar[str] = "move_base"
    not_by_hand: ClassVar[str] = ""
    """Why operators do not drive such a robot by hand; empty if they may."""
    demands: ClassVar[Demands | None] = Demands(
        0.6, rates={topics.SCAN.name: topics.SCAN_RATE, topics.ODOM.name: topics.ODOM_RATE}
    )
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.SIMPLE_GOAL, topics.GOAL_POSE, topics.MOVE_BASE_GOAL, topics.MOVE_BASE_CANCEL,
        topics.GOAL_UPDATE, topics.MOVE_BASE_GOAL_UPDATE, topics.PEOPLE_STATE, topics.AMCL_STATUS, topics.STOP_STATE,
        topics.SCAN, topics.ODOM, topics.TF, topics.TF_STATIC, topics.ROBOTS, topics.PEOPLE, topics.SPEED_LIMIT,
        *NAVIGATE_THROUGH_POSES[:2], *FOLLOW_PATH[:2], *RobotPaths.subscribes, *Behaviors.subscribes,
        *Teleop.subscribes, *ObjectFollower.subscribes,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        topics.CMD_VEL, topics.PLAN, topics.LOCAL_PLAN, topics.MOVE_BASE_CURRENT_GOAL, *PUBLISHED,
        topics.MOVE_BASE_STATUS, topics.MOVE_BASE_FEEDBACK, topics.MOVE_BASE_RESULT,
        topics.NAVIGATE_TO_POSE_FEEDBACK, *NAVIGATE_THROUGH_POSES[2:], *FOLLOW_PATH[2:], *RobotPaths.publishes,
        *Behaviors.publishes,
        *Teleop.publishes, *ObjectFollower.publishes,
    )  # fmt: skip
    services: ClassVar[tuple[Service, ...]] = (
        Service("move_base/make_plan", GetPlan),
        Service("move_base/compute_path", ComputePath),
        Service("is_path_valid", nav2_msgs.IsPathValid),
        Service("move_base/clear_costmaps", EmptyService),
        Service("global_costmap/clear_entirely_global_costmap", nav2_msgs.ClearEntireCostmap),
        Service("local_costmap/clear_entirely_local_costmap", nav2_msgs.ClearEntireCostmap),
    )

    def __init__(
        self, context: Context, *, surroundings: Surroundings, costmap_topics: CostmapTopics,
        planner: Planner, path_planners: Mapping[str, Planner], controller: Controller,
        recoveries: Sequence[tuple[str, Recovery]], parameters: MoveBaseParameters, threads: Threads,
        processors: Processors, version: str | None, passive_safety: PassiveSafety, teleop: Callable[..., Teleop],
        top_speed: float,
        limits_by_place: Callable[[MapLayers, Callable[[], float]], Sequence[LimitsByPlace]] = without_limits,
        adapt: Callable[[MapLayers], MapLayers] = unchanged, build: Build | None = None,
    ) -> None:  # fmt: skip
        super().__init__(context)
        self._processors, self._limits_by_place, self._adapt = processors, limits_by_place, adapt
        processor = processors(surroundings.static, version)
        self._limits = SpeedLimits(limits_by_place(surroundings.layers, context.now))
        self._static_layer = None if build is None else StaticLayer(context, build, self.use_layers, self._goal_poses)
        self._progress_checker = ProgressChecker()
        self._costmap_topics, self._surroundings = costmap_topics, surroundings
        make = self._make_planner
        self._planner = make(context, planner, surroundings, parameters, threads=threads, processor=processor)
        self._period, self._topics = 1.0 / parameters.controller_frequency, ActionTopics(context)
        self._machine = MoveBase(parameters, [name for name, _ in recoveries])
        self._executor = OrderExecutor(
            context, self._feed, self._machine.goals,
            surroundings=surroundings, planner=self._planner, controller=controller,
            recoveries=[recovery for _, recovery in recoveries], topics=self._topics, limits=self._limits,
            passive_safety=passive_safety, period=self._period, threads=threads, progress=GoalProgress(top_speed),
        )  # fmt: skip
        self._behaviors = Behaviors(
            context, surroundings, [recovery for _, recovery in recoveries], top_speed=top_speed, period=self._period,
            send=self._executor.send, preempt=self._preempt, check_released=self._executor.check_released,
        )  # fmt: skip
        self._teleop = teleop(
            context, surroundings, limits=self._limits, passive_safety=passive_safety, refusal=self.not_by_hand,
            driving=self._executor, make_way=self._make_way, go_on=self._go_on,
        )  # fmt: skip
        self._paths = RobotPaths(
            context, surroundings, parameters.base_global_planner, threads, processor=processor, tuned=path_planners
        )
        self._objects = ObjectFollower(context, surroundings, self, self._topics)
        self._cycle: Timer | None = None
        self._events, self._counter, self._handling = deque[events.Event](), 0, False

    def _make_planner(self, *arguments: Any, **options: Any) -> RobotPlanner:
        """Return what makes the plans for goals, from the arguments of `RobotPlanner`."""
        return RobotPlanner(*arguments, **options)

    @property
    def busy(self) -> bool:
        """True while a goal is active, a behaviour runs, or somebody drives by hand."""
        driving = self._machine.goals.active is not None or self._objects.active
        return driving or self._behaviors.active or bool(self._teleop.holds)

    @property
    def costs(self) -> Costmap | None:
        """The local costmap; None before the first goal."""
        return self._surroundings.costs

    def use_layers(self, layers: MapLayers, version: str | None = None) -> None:
        """Replace the map while the robot drives.

        The goal stays. The plan is checked on the new map, and the robot plans again if it is blocked. Obstacles that
        were seen are kept where the cells of both maps coincide. Plans of the map before are neither reused nor stored.

        Parameters
        ----------
        layers : MapLayers
            Layers of the new map, in the frame of the one before, inflated for the robot.
        version : str, optional
            Version of a published map, whose stored plans may be reused; None if it is not published.

        Raises
        ------
        Unavailable
            The layers lack a mask that the robot's parameters require; the map is not replaced.
        """
        self._limits.use_places(self._limits_by_place(layers, self.context.now))
        layers = self._adapt(layers)
        before = self._surroundings.static.info
        self._surroundings.use_layers(layers)
        processor = self._processors(layers.costmap, version)
        self._planner.use_map(before, processor, other_version=version is not None)
        self._paths.services.use_map(layers.costmap, processor)
        if self._machine.goals.active is None:
            return
        now = self.context.elapsed()
        with contextlib.suppress(PPaaSError):  # without a pose, the robot stands
            self._surroundings.look_around(self._surroundings.pose(now), now)
            self._executor.check_plan()

    def _goal_poses(self) -> tuple[Pose2D, ...]:
        active = self._machine.goals.active
        return () if active is None else (*active.goal.through, active.goal.pose)

    def start(self) -> None:
        """Start publishing the status of goals, and costmaps while somebody subscribes."""
        self.context.every(STATUS_PERIOD, self._publish_statuses)
        self.context.every(self._costmap_topics.period, self._costmap_topics.publish)

    def _publish_statuses(self) -> None:
        self._topics.status(self._machine.goals)
        for part in (self._paths, self._behaviors, self._objects):
            part.publish_statuses()

    # -- messages and calls --------------------------------------------------------------------------------------------

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message; an invalid goal does not affect the active one.

        Raises
        ------
        InvalidInput
            A number is not finite, or a goal has no frame.
        TransformError
            A frame is unknown.
        """
        if any(part.take(topic, message) for part in (self._paths, self._behaviors, self._teleop, self._objects)):
            return
        now = self.context.elapsed()
        message = update_of(topic, message) or message
        match message:
            case GoalUpdate():
                self._on_update(message)
            case PoseStamped():
                self._on_goal(message, GoalID(message.header.stamp))
            case MoveBaseActionGoal():
                self._on_goal(message.goal.target_pose, message.goal_id)
            case nav2_msgs.NavigateThroughPosesActionGoal() | FollowPathActionGoal():
                self._on_way(message)
            case GoalID():
                self._on_cancel(topic, events.CancelReceived(now, message.id, message.stamp.seconds()))
            case LaserScan() | Odometry() | TFMessage() | RobotStates() | People() | PeopleState() | String():
                self._surroundings.take(topic, message, now, self.context.now())
            case nav2_msgs.SpeedLimit():
                self._limits.take(message)
            case StopState():
                self._hold(message.text)
            case _:
                raise InvalidInput(f"{self.name} does not accept {type(message).__name__} on topic {topic!r}")

    def _on_goal(self, target: PoseStamped, goal_id: GoalID) -> None:
        self._drive(pose_in(self._surroundings.frames.tree, MAP, target, "a goal"), goal_id)

    def _on_way(self, message: nav2_msgs.NavigateThroughPosesActionGoal | FollowPathActionGoal) -> None:
        """Take a goal with poses on the way, or one with a path."""
        if isinstance(message, nav2_msgs.NavigateThroughPosesActionGoal):
            poses = poses_of(message.goal, self._surroundings.frames.tree)
            self._drive(poses[-1], message.goal_id, tuple(poses[:-1]), many=True)
            return
        wanted, goal_id = message.goal, message.goal_id
        try:
            check_controller(wanted.controller_id, (self._executor.controller_name,))
            path = path_to_follow(wanted, self._surroundings.frames.tree)
        except PPaaSError as error:
            refused = events.Goal(goal_id.id, Pose2D(0.0, 0.0), goal_id.stamp.seconds())
            self._topics.path_result(refused, Status.ABORTED, str(error), error_of(error))
            return
        self._drive(path[-1], goal_id, path=path)

    def _drive(
        self, pose: Pose2D, goal_id: GoalID, through: tuple[Pose2D, ...] = (), *, many: bool = False,
        path: tuple[Pose2D, ...] = (),
    ) -> None:  # fmt: skip
        stamp = goal_id.stamp.seconds() or self.context.now()
        self._counter += 1
        name = goal_id.id or f"{self.name}-{self._counter}-{stamp:.3f}"
        goal = events.Goal(name, pose, stamp, through, many, path=path)
        gives = gives_way(goal, self._machine.goals.active, behaves=self._behaviors.active)
        if refusal := self._teleop.holds or (GAVE_WAY if gives else ""):
            self._topics.result(goal, Status.REJECTED, refusal)
            return
        if not self._machine.goals.knows(name, self.context.elapsed()):
            self._topics.traces.begin(goal)
            self._planner.head_for(pose)
            self._behaviors.preempt(f"Replaced by another goal: {name}")
            if not name.startswith(OBJECT_GOAL):
                self._objects.replaced(f"Replaced by another goal: {name}")
        self._feed(events.GoalReceived(self.context.elapsed(), goal))
        self._tick()

    # -- a moving goal of `ObjectFollower` -----------------------------------------------------------------------------

    def drive_to(self, pose: Pose2D, goal_id: GoalID) -> None:
        """Drive to a pose in the map frame, in place of the goal before."""
        self._drive(pose, goal_id)

    def move_goal(self, pose: Pose2D) -> None:
        """Move the goal that the robot drives to."""
        self._planner.head_for(pose)
        self._feed(events.GoalUpdated(self.context.elapsed(), pose, 0.0))

    def end_goal(self, reason: str) -> None:
        """End the goal that the robot drives to."""
        self._feed(events.Preempted(self.context.elapsed(), reason))

    def _on_update(self, update: GoalUpdate) -> None:
        """Move the active goal, if the update is for it; a path of a client is not moved."""
        active = self._machine.goals.active
        if active is None or active.goal.path or not is_update_of(update, active.goal):
            return
        pose = pose_in(self._surroundings.frames.tree, MAP, update.target_pose, "an update of a goal")
        self._planner.head_for(pose)
        self._feed(events.GoalUpdated(self.context.elapsed(), pose, limit_of_goal(update, active.goal)))

    def _on_cancel(self, topic: str, cancel: events.CancelReceived) -> None:
        """Cancel the goal; a cancel of all goals stops the robot, so it ends a behaviour too."""
        active = self._machine.goals.active
        if topic == topics.MOVE_BASE_CANCEL.name:
            self._feed(cancel)
            self._behaviors.cancel(cancel)
            self._objects.cancel(cancel)
        elif active is not None and (active.goal.path if topic == FOLLOW_PATH.cancel.name else active.goal.many):
            self._feed(cancel)

    def _hold(self, reason: str) -> None:
        """Stand while the robot is stopped, for a reason; go on by another plan once there is none."""
        self._executor.held = reason
        self._look_again()

    def _preempt(self, reason: str) -> str:
        """End the goal for a behaviour; return why no behaviour may run instead, if somebody drives by hand."""
        if not self._teleop.holds:
            self._objects.replaced(reason)
            self._feed(events.Preempted(self.context.elapsed(), reason))
        return self._teleop.holds

    def _make_way(self, reason: str) -> None:
        """Wait with the goal, and end the behaviour, for somebody who drives by hand."""
        self._executor.by_hand = reason
        self._behaviors.preempt(reason)
        self._look_again()

    def _go_on(self, reason: str, resumes: bool) -> None:
        """Go on to the goal that has waited for somebody who drove by hand, or end it."""
        self._executor.by_hand = ""
        if resumes:
            self._look_again()
        else:
            self._feed(events.Preempted(self.context.elapsed(), reason))

    def _look_again(self) -> None:
        self._feed(events.Held(self.context.elapsed()))
        self._tick()

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Plan a path without moving, or clear the observed obstacles.

        Raises
        ------
        InvalidInput
            A pose is not finite, or has no frame; or a layer to clear is unknown.
        TransformError
            A frame or the robot's own pose is unknown.
        """
        maps = CLEARED.get(service)
        if maps is None:
            self._paths.call(request, reply)
            return
        answer = answer_to_clear(request)
        self._surroundings.clear(affected_maps=maps)
        reply(answer)

    def _keep_cycle(self) -> None:
        """Run the control cycle only while a goal is active, so that a waiting robot costs nothing."""
        driving = self._machine.goals.active is not None
        if self._cycle is None and driving:
            self._cycle = self.context.every(self._period, self._tick)
        elif self._cycle is not None and not driving:
            self._cycle.stop()
            self._cycle = None

    def _tick(self) -> None:
        if self._machine.goals.active is None:
            return
        now = self.context.elapsed()
        try:
            self._executor.check_released()
            pose = self._surroundings.pose(now)
            self._surroundings.look_around(pose, now)
            if self._static_layer is not None and (reason := self._static_layer.waits()):
                raise Unavailable(reason)
        except PPaaSError as error:
            self._feed(events.ControlTick(now, None, str(error)))
            return
        self._executor.see(pose)
        no_progress = self._progress_checker.look(now, self._executor.sent, self._surroundings.frames.odometry())
        self._feed(events.ControlTick(now, pose, no_progress=no_progress))

    # -- events ------------------------------------------------------------------------------------------------------

    def _feed(self, event: events.Event) -> None:
        """Pass an event to the state machine, then the events that result from executing its orders."""
        self._events.append(event)
        if self._handling:
            return
        self._handling = True
        try:
            while self._events:
                for order in self._machine.handle(self._events.popleft()):
                    self._executor.execute(order)
        finally:
            self._handling = False
        self._keep_cycle()

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the active goal and the speed limit as JSON."""
        active, limit = self._machine.goals.active, self._limits.received
        goal = active.goal if active else None
        spent = self._executor.progress.spent(self.context.elapsed()) if active else 0.0
        state = MoveBaseState(
            goal, self._counter, limit.speed_limit, limit.percentage, spent, self._paths.actions.active,
            self._behaviors.checkpoint(), self._executor.by_hand, self._paths.routes.checkpoint(),
            self._objects.checkpoint(),
        )  # fmt: skip
        return msgspec.json.encode(state)

    def restore(self, state: bytes) -> None:
        """Continue to the goal of a checkpoint, with a new plan from the robot's current pose.

        The goal of a robot that somebody drove by hand ends: nobody has given the robot back.
        """
        restored = from_json(state, MoveBaseState)
        self._counter = restored.counter
        self._limits.take(nav2_msgs.SpeedLimit(restored.speed_limit, restored.percentage))
        if restored.goal is not None and not restored.goal.id.startswith(OBJECT_GOAL):
            self._feed(events.GoalReceived(self.context.elapsed(), restored.goal))
            self._executor.progress.resume(restored.seconds)
            if restored.by_hand:
                self._feed(events.Preempted(self.context.elapsed(), restored.by_hand))
        self._paths.actions.restore(restored.paths)
        self._behaviors.restore(restored.behavior)
        self._paths.routes.restore(restored.route)
        self._objects.restore(restored.object)

    def carry_over(self, state: bytes) -> None:
        """End the goal of a checkpoint, which is a pose on another map."""
        restored = from_json(state, MoveBaseState)
        self._counter = restored.counter
        if restored.goal is not None and not restored.goal.id.startswith(OBJECT_GOAL):
            self._feed(events.GoalReceived(self.context.elapsed(), restored.goal))
            self._feed(events.Preempted(self.context.elapsed(), ON_OTHER_MAP))
