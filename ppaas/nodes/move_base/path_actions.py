"""Paths that clients ask for and the robot does not follow: Nav2's path actions, around what the robot sees."""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import ClassVar

import msgspec

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidInput, PlanCancelled, PlanningError, PlanTransformError, PPaaSError, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Duration, Header
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.nav2_msgs import (
    ComputePathThroughPosesActionGoal,
    ComputePathThroughPosesResult,
    ComputePathToPoseActionGoal,
    ComputePathToPoseResult,
    IsPathValidRequest,
)
from ppaas.messages.nav_msgs import GetPlanRequest, Path
from ppaas.messages.ppaas_msgs import ComputePathRequest
from ppaas.navigation.action_goals import ConcurrentGoals, cancels
from ppaas.navigation.events import CancelReceived
from ppaas.nodes.action_publisher import ActionPublisher
from ppaas.nodes.base import Context, Job, Payload, Reply, Topic
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import expect, pose_in
from ppaas.nodes.move_base.client_paths import check_path
from ppaas.nodes.move_base.route_actions import RouteActions
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.nodes.move_base.through_goals import MAX_POSES
from ppaas.nodes.nav2_actions import COMPUTE_PATH_THROUGH_POSES, COMPUTE_PATH_TO_POSE
from ppaas.nodes.planner_server.path_services import PathServices, get_plan_response
from ppaas.planners.base import Planner, PlanResult
from ppaas.plans.reuse.processor import PlanProcessor
from ppaas.thread_budget import Threads

# -- actions ``compute_path_to_pose`` and ``compute_path_through_poses`` -----------------------------------------------

UNKNOWN = 200
"""``error_code`` of Nav2's ComputePathToPose for errors that are not of planning."""

THROUGH = 100
"""Difference between the error codes of ComputePathThroughPoses and ComputePathToPose."""

NO_POSES = 309
"""``error_code`` of Nav2's ComputePathThroughPoses for an empty list."""

OWN_PLANNER = ("", "GridBased")
"""Values of ``planner_id`` that mean the robot's own planner; the second is the name of Nav2's only one by default."""


class PathGoal(msgspec.Struct, frozen=True):
    """Path to compute; checkpoints contain it as JSON.

    Parameters
    ----------
    id, stamp
        As of any action's goal.
    poses : tuple of Pose2D
        Poses to pass and the goal, in the map frame.
    start : Pose2D, optional
        In the map frame; None only while it is not known.
    planner : str
        Name of the planner; empty for the robot's own.
    through : bool
        Whether it is a goal of ``compute_path_through_poses``.
    """

    id: str
    stamp: float
    poses: tuple[Pose2D, ...]
    start: Pose2D | None = None
    planner: str = ""
    through: bool = False


class PathActions:
    """Serves both actions, for any number of clients; unlike in Nav2, a goal does not preempt another.

    Parameters
    ----------
    context : Context
        Context of the node that serves them.
    paths : PathServices
        Plans.
    surroundings : Surroundings
        Pose and frames of the robot.
    seen : callable
        Returns the costmap with the obstacles that the robot sees now.
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (
        COMPUTE_PATH_TO_POSE.goal, COMPUTE_PATH_TO_POSE.cancel,
        COMPUTE_PATH_THROUGH_POSES.goal, COMPUTE_PATH_THROUGH_POSES.cancel,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (*COMPUTE_PATH_TO_POSE[2:], *COMPUTE_PATH_THROUGH_POSES[2:])

    def __init__(
        self, context: Context, paths: PathServices, surroundings: Surroundings, seen: Callable[[], Costmap]
    ) -> None:
        self._context = context
        self._paths = paths
        self._surroundings = surroundings
        self._seen = seen
        self._goals: dict[bool, ConcurrentGoals[PathGoal]] = {False: ConcurrentGoals(), True: ConcurrentGoals()}
        self._publishers: dict[bool, ActionPublisher[PathGoal]] = {
            False: ActionPublisher(context, COMPUTE_PATH_TO_POSE),
            True: ActionPublisher(context, COMPUTE_PATH_THROUGH_POSES),
        }
        self._handlers: dict[str, Callable[[Payload], None]] = {
            COMPUTE_PATH_TO_POSE.goal.name: self._on_goal,
            COMPUTE_PATH_TO_POSE.cancel.name: partial(self._on_cancel, False),
            COMPUTE_PATH_THROUGH_POSES.goal.name: self._on_goal_through,
            COMPUTE_PATH_THROUGH_POSES.cancel.name: partial(self._on_cancel, True),
        }
        self._jobs: dict[tuple[bool, str], Job] = {}
        self._counter = 0

    def take(self, topic: str, message: Payload) -> bool:
        """Handle a message of one of the topics; return whether it is of one.

        Raises
        ------
        InvalidInput
            A pose is not finite or has no frame, or there are too many poses.
        """
        handle = self._handlers.get(topic)
        if handle is not None:
            handle(message)
        return handle is not None

    def publish_statuses(self) -> None:
        """Publish the statuses of all goals."""
        for through, goals in self._goals.items():
            self._publishers[through].status(goals)

    # -- goals ---------------------------------------------------------------------------------------------------------

    def _on_goal(self, message: Payload) -> None:
        request = expect(message, ComputePathToPoseActionGoal)
        wanted = request.goal
        if len(wanted.viapoints) >= MAX_POSES:
            raise InvalidInput(f"viapoints may have at most {MAX_POSES - 1} poses, not {len(wanted.viapoints)}")
        start = wanted.start if wanted.use_start else None
        self._begin(request.goal_id, [*wanted.viapoints, wanted.goal], start, wanted.planner_id)

    def _on_goal_through(self, message: Payload) -> None:
        request = expect(message, ComputePathThroughPosesActionGoal)
        wanted = request.goal
        if len(wanted.goals) > MAX_POSES:
            raise InvalidInput(f"goals may have at most {MAX_POSES} poses, not {len(wanted.goals)}")
        start = wanted.start if wanted.use_start else None
        self._begin(request.goal_id, wanted.goals, start, wanted.planner_id, through=True)

    def _begin(
        self, goal_id: GoalID, poses: Sequence[PoseStamped], start: PoseStamped | None, planner: str,
        *, through: bool = False,
    ) -> None:  # fmt: skip
        if self._goals[through].knows(goal_id.id, self._context.elapsed()):
            return
        self._counter += 1
        stamp = goal_id.stamp.seconds() or self._context.now()
        goal = PathGoal(goal_id.id or f"path-{self._counter}-{stamp:.3f}", stamp, (), None, "", through)
        error: PlanningError | None = None
        try:
            goal = self._resolved(goal, poses, start, "" if planner in OWN_PLANNER else planner)
        except TransformError as unknown:
            error = PlanTransformError(str(unknown))
        self._accept(goal)
        if error is not None:
            self._done(goal, error)
        else:
            self._plan(goal)

    def _resolved(
        self, goal: PathGoal, poses: Sequence[PoseStamped], start: PoseStamped | None, planner: str
    ) -> PathGoal:
        """Return a goal with its poses in the map frame; without a start the path begins at the robot."""
        around = self._surroundings
        tree = around.frames.tree
        return msgspec.structs.replace(
            goal,
            poses=tuple(pose_in(tree, MAP, pose, f"pose {number}") for number, pose in enumerate(poses, 1)),
            start=around.pose(self._context.elapsed()) if start is None else pose_in(tree, MAP, start, "the start"),
            planner=planner,
        )

    def _accept(self, goal: PathGoal) -> None:
        self._goals[goal.through].accept(goal, "planning")
        self._publishers[goal.through].status(self._goals[goal.through])

    def _plan(self, goal: PathGoal) -> None:
        if not goal.poses:
            self._end(goal, Status.ABORTED, "goals is empty: there is no pose to plan to", NO_POSES)
            return
        assert goal.start is not None, "the poses are resolved"
        try:
            job = self._paths.plan(
                goal.start, goal.poses[-1], partial(self._done, goal), partial(_result, goal),
                planner=goal.planner, costmap=self._seen(), through=goal.poses[:-1],
            )  # fmt: skip
        except PPaaSError as error:
            self._done(goal, error)
        else:
            if goal in self._goals[goal.through].active:
                self._jobs[goal.through, goal.id] = job

    def _on_cancel(self, through: bool, message: Payload) -> None:
        cancel = expect(message, GoalID)
        event = CancelReceived(self._context.elapsed(), cancel.id, cancel.stamp.seconds())
        for goal in self._goals[through].active:
            if cancels(event, goal) and (job := self._jobs.get((through, goal.id))) is not None:
                job.cancel()

    # -- results -------------------------------------------------------------------------------------------------------

    def _done(self, goal: PathGoal, result: Payload | PPaaSError) -> None:
        self._jobs.pop((goal.through, goal.id), None)
        match result:
            case PlanCancelled():
                self._end(goal, Status.PREEMPTED, "The goal was cancelled.", 0)
            case PlanningError():
                self._end(goal, Status.ABORTED, str(result), result.code + (THROUGH if goal.through else 0))
            case PPaaSError():
                self._end(goal, Status.ABORTED, str(result), UNKNOWN + (THROUGH if goal.through else 0))
            case Message():
                self._publish(goal, Status.SUCCEEDED, "", result)

    def _end(self, goal: PathGoal, status: Status, text: str, code: int) -> None:
        kind = ComputePathThroughPosesResult if goal.through else ComputePathToPoseResult
        empty = kind(Path(Header(frame_id=MAP), []), Duration(), code, text if code else "")
        self._publish(goal, status, text, empty)

    def _publish(self, goal: PathGoal, status: Status, text: str, result: Message) -> None:
        goals, publisher = self._goals[goal.through], self._publishers[goal.through]
        goals.end(goal, self._context.elapsed(), status, text)
        publisher.result(goal, status, text, result)
        publisher.status(goals)

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    @property
    def active(self) -> tuple[PathGoal, ...]:
        """Paths in progress."""
        return tuple(goal for goals in self._goals.values() for goal in goals.active)

    def restore(self, goals: Sequence[PathGoal]) -> None:
        """Compute the paths that were in progress again."""
        for goal in goals:
            if not self._goals[goal.through].knows(goal.id, self._context.elapsed()):
                self._accept(goal)
                self._plan(goal)


def _result(goal: PathGoal, plan: PlanResult) -> Message:
    path, seconds = plan.to_message(), Duration.of(plan.seconds)
    if goal.through:
        return ComputePathThroughPosesResult(path, seconds, last_reached_index=len(goal.poses) - 1)
    return ComputePathToPoseResult(path, seconds)


# -- paths that a robot's clients ask for, around what the robot sees, which the robot does not follow -----------------


class RobotPaths:
    """Serves Move Base's path services, and owns the actions that compute paths.

    Parameters
    ----------
    context : Context
        Context of the node that serves them.
    surroundings : Surroundings
        Pose, frames and observed obstacles of the robot.
    default : str
        Planner of requests that name none.
    threads : callable
        Returns the largest number of threads that kernels may use now.
    processor : PlanProcessor
        Finds stored plans.
    tuned : dict of str to Planner
        Planners with their own parameters, by name; they must not be used by others.

    Attributes
    ----------
    actions : PathActions
    services : PathServices
    routes : RouteActions
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (*PathActions.subscribes, *RouteActions.subscribes)
    publishes: ClassVar[tuple[Topic, ...]] = (*PathActions.publishes, *RouteActions.publishes)

    def __init__(
        self,
        context: Context,
        surroundings: Surroundings,
        default: str,
        threads: Threads,
        *,
        processor: PlanProcessor,
        tuned: Mapping[str, Planner],
    ) -> None:
        self._context = context
        self._surroundings = surroundings
        self.services = PathServices(context, surroundings.static, default, threads, processor=processor, tuned=tuned)
        self.actions = PathActions(context, self.services, surroundings, self._seen)
        self.routes = RouteActions(context, surroundings)

    def take(self, topic: str, message: Payload) -> bool:
        """Handle a message of one of the topics; return whether it is of one."""
        return self.actions.take(topic, message) or self.routes.take(topic, message)

    def publish_statuses(self) -> None:
        """Publish the statuses of all goals."""
        self.actions.publish_statuses()
        self.routes.publish_statuses()

    def call(self, request: Message, reply: Reply) -> None:
        """Plan a path for a call of ``make_plan`` or ``compute_path``, or check one for ``is_path_valid``.

        Raises
        ------
        InvalidInput
            A pose is not finite, or has no frame.
        TransformError
            A frame or the robot's own pose is unknown.
        """
        if isinstance(request, ComputePathRequest):
            self.services.compute(request, reply, self._seen())
        elif isinstance(request, IsPathValidRequest):
            reply(self._check(request))
        else:
            self._make_plan(expect(request, GetPlanRequest), reply)

    def _make_plan(self, question: GetPlanRequest, reply: Reply) -> None:
        """Plan around observed obstacles as for a goal, without following the plan; an active goal continues."""
        around = self._surroundings
        goal = pose_in(around.frames.tree, MAP, question.goal, "the goal")
        # As in move_base, a start without a frame is the robot's pose.
        here = not question.start.header.frame_id
        now = self._context.elapsed()
        start = around.pose(now) if here else pose_in(around.frames.tree, MAP, question.start, "the start")
        self.services.plan(start, goal, reply, get_plan_response, tolerance=question.tolerance, costmap=self._seen())

    def _check(self, request: IsPathValidRequest) -> Message:
        around, pose = self._surroundings, None
        with contextlib.suppress(TransformError):  # without a pose, the whole path is checked
            pose = around.pose(self._context.elapsed())
        return check_path(request, self._seen(), around.frames.tree, pose)

    def _seen(self) -> Costmap:
        """Return the costmap of the map with the obstacles that the robot sees now."""
        around, now = self._surroundings, self._context.elapsed()
        with contextlib.suppress(TransformError):  # without a pose, new scans cannot be used
            around.look_around(around.pose(now), now)
        return around.seen()
