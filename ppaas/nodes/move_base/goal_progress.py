"""Progress to the active goal, and the actions' status, feedback and results, with the traces of goals."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from ppaas.bounded import BoundedDict
from ppaas.controllers.followed_path import FollowedPath
from ppaas.geometry import Pose2D, Poses, wrap_angle
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Duration, Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import (
    MoveBaseActionFeedback,
    MoveBaseActionResult,
    MoveBaseFeedback,
)
from ppaas.messages.nav2_motions import FollowPathError, FollowPathFeedback, FollowPathResult, TrackingFeedback
from ppaas.messages.nav2_msgs import (
    NavigateThroughPosesFeedback,
    NavigateThroughPosesResult,
    NavigateToPoseActionFeedback,
    NavigateToPoseFeedback,
    WaypointProgress,
    WaypointStatus,
)
from ppaas.navigation.action_goals import GoalList, GoalState
from ppaas.navigation.events import Goal
from ppaas.navigation.move_base import Trigger
from ppaas.nodes import topics
from ppaas.nodes.action_publisher import ActionPublisher, status_array, status_of
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP
from ppaas.nodes.move_base.client_paths import CODES
from ppaas.nodes.nav2_actions import FOLLOW_PATH, NAVIGATE_THROUGH_POSES
from ppaas.tracing.spans import NOTHING, Span, Within, entry, traceparent

# -- progress to the active goal ---------------------------------------------------------------------------------------

MEMORY = 5.0
"""Time constant of the mean speed, from which the remaining time is estimated [s]."""

SLOWEST = 0.05
"""Speed below which a robot counts as waiting; the remaining time is then estimated with this speed [m/s]."""


PASSED = 0.5
"""Distance along the plan before a pose on the way at which it counts as passed [m]."""

BEYOND = 0.2
"""Distance beyond the next pose on the way to which the local planner sees the plan [m].

Its end must not be near the robot, which would stop there: a round trip ends where it begins. At the distance `PASSED`
from a pose, the local planner still sees more than the way on which it slows down.
"""


class GoalProgress:
    """Distance and time that remain to the active goal, and the poses on the way.

    The distance is that along the plan, or along the straight line before the first plan. The time is the distance
    divided by the mean speed of the last seconds; a robot that has just begun counts as fast as it may drive.

    Parameters
    ----------
    top_speed : float
        Fastest speed of the robot [m/s].

    Attributes
    ----------
    distance : float
        Remaining distance [m].
    speed : float
        Speed of the robot at the last update [m/s].
    """

    def __init__(self, top_speed: float) -> None:
        self._top_speed = max(top_speed, SLOWEST)
        self._goal = Pose2D(0.0, 0.0)
        self._path: FollowedPath | None = None
        self._poses: Poses = np.empty((0, 7))
        self._marks: list[float] = []
        self._began = self._updated = 0.0
        self._speed = self._top_speed
        self.distance = self.speed = 0.0

    def begin(self, goal: Pose2D, now: float) -> None:
        """Start to drive to a goal in the map frame."""
        self._goal, self._path, self._marks = goal, None, []
        self._began = self._updated = now
        self._speed = self._top_speed

    def aim(self, goal: Pose2D) -> None:
        """Take the goal, which is elsewhere now."""
        self._goal = goal

    def resume(self, spent: float) -> None:
        """Count the time for which the goal was active in another executor [s]."""
        self._began -= spent

    def follow(self, poses: Poses, through: Sequence[Pose2D] = ()) -> None:
        """Measure along a new plan (n, 7) that passes poses; raises ``InvalidInput`` as `FollowedPath` does."""
        self._path, self._poses = FollowedPath(poses), poses
        self._marks, index = [], 0
        for pose in through:
            apart = np.hypot(*(poses[index:, :2] - pose[:2]).T)
            index += int(np.argmin(apart))
            self._marks.append(float(self._path.lengths[index]))

    @property
    def has_plan(self) -> bool:
        """Whether there is a plan to the active goal."""
        return self._path is not None

    @property
    def rest(self) -> Poses:
        """The plan from the robot to its end."""
        assert self._path is not None, "there is a plan"
        return self._poses[self._path.reached :]

    @property
    def ahead(self) -> Poses:
        """The plan from the robot to a little beyond the next pose on the way; to its end if there is none."""
        assert self._path is not None, "there is a plan"
        first, lengths = self._path.reached, self._path.lengths
        last = int(np.searchsorted(lengths, self._marks[0] + BEYOND, side="right")) if self._marks else len(lengths)
        return self._poses[first : max(last, first + 1)]

    def take_passed(self, pose: Pose2D) -> int:
        """Return how many poses on the way the robot has passed since the last call."""
        if self._path is None or not self._marks:
            return 0
        self._path.locate(pose)
        covered = float(self._path.lengths[self._path.reached])
        count = sum(mark - PASSED <= covered for mark in self._marks)
        self._marks = self._marks[count:]
        return count

    def take_next(self) -> int:
        """Count the next pose on the way as passed; return how many there were, 0 or 1."""
        count = min(len(self._marks), 1)
        self._marks = self._marks[count:]
        return count

    def update(self, pose: Pose2D, speed: float, now: float) -> None:
        """Take the pose in the map frame and the speed [m/s] of the robot."""
        weight = 1.0 - math.exp(-max(now - self._updated, 0.0) / MEMORY)
        self._speed += weight * (abs(speed) - self._speed)
        self._updated, self.speed = now, speed
        if self._path is None:
            self.distance = pose.distance_to(self._goal)
        else:
            self._path.locate(pose)
            self.distance = self._path.to_go(pose)

    def tracking_error(self, pose: Pose2D) -> tuple[float, float]:
        """Return how far a pose in the map frame is off the plan.

        Returns
        -------
        distance : float
            Distance from the plan [m], positive to the left of it; 0 without a plan.
        heading : float
            Heading against the direction of the plan [rad], from −π to π.
        """
        if self._path is None:
            return 0.0, 0.0
        first = min(self._path.reached, len(self._poses) - 2)
        if first < 0:
            return 0.0, 0.0
        (x, y), (next_x, next_y) = self._poses[first, :2], self._poses[first + 1, :2]
        way = math.atan2(next_y - y, next_x - x)
        left = (pose.y - y) * math.cos(way) - (pose.x - x) * math.sin(way)
        return float(left), wrap_angle(pose.theta - way)

    @property
    def index(self) -> int:
        """Index of the pose of the plan at which the robot is."""
        return 0 if self._path is None else self._path.reached

    def spent(self, now: float) -> float:
        """Return the time since the goal became active [s]."""
        return max(now - self._began, 0.0)

    def remaining(self) -> float:
        """Return the estimated time to the goal [s]."""
        return self.distance / max(self._speed, SLOWEST)


# -- traces of goals: a span from the goal to its result, of which plans for it are parts ------------------------------

MOST_TRACED = 100
"""Number of goals without a result whose spans are known; the oldest are forgotten first."""

FAILED = (Status.ABORTED, Status.REJECTED, Status.LOST)
"""Results that are errors of a span."""


class GoalTraces:
    """Spans of the goals of a robot that have no result yet."""

    def __init__(self) -> None:
        self._spans: BoundedDict[str, Span] = BoundedDict(MOST_TRACED)

    def begin(self, goal: Goal) -> None:
        """Begin the span of a goal: in the trace of the client that sent it, or in a new one."""
        x, y = goal.pose[:2]
        begun = entry("goal", traceparent(), {"ppaas.goal": goal.id, "ppaas.goal.x": x, "ppaas.goal.y": y})
        if begun is not NOTHING:
            self._spans[goal.id] = begun

    def of(self, goal: Goal | None) -> Within:
        """Return a context manager whose block works for a goal; for None, it changes nothing."""
        return (NOTHING if goal is None else self._spans.get(goal.id, NOTHING)).active()

    def end(self, goal: Goal, status: Status, text: str) -> None:
        """End the span of a goal with its result."""
        ended = self._spans.pop(goal.id, NOTHING)
        ended.set({"ppaas.goal.status": status.name.lower()})
        if status in FAILED:
            ended.fail(status.name.lower(), text)
        ended.end()


# -- publishers of the actions ``move_base``, ``navigate_through_poses`` and ``follow_path`` --------------------------

NONE, UNKNOWN = 0, 9100
"""``error_code`` of NavigateThroughPoses for success, and for all failures of Move Base."""

PROGRESS_PERIOD = 0.5
"""Period of Nav2's feedback, which changes slowly [s]."""


class ActionTopics:
    """Publishes status, feedback and results of goals.

    Parameters
    ----------
    context : Context
        The node's context.

    Attributes
    ----------
    traces : GoalTraces
        Traces of the goals, which end with their results.
    on_end : callable, optional
        Called with a goal that has ended, its status and text.
    """

    def __init__(self, context: Context) -> None:
        self.traces = GoalTraces()
        self._context = context
        self._through: ActionPublisher[Goal] = ActionPublisher(context, NAVIGATE_THROUGH_POSES)
        self._along: ActionPublisher[Goal] = ActionPublisher(context, FOLLOW_PATH)
        self._next_progress = float("-inf")
        self.on_end: Callable[[Goal, Status, str], None] | None = None

    def _header(self, frame_id: str = "") -> Header:
        return Header(stamp=Time.of(self._context.now()), frame_id=frame_id)

    def stamped(self, pose: Pose2D) -> PoseStamped:
        """Return a pose in the map frame, stamped with the current time."""
        return PoseStamped(self._header(MAP), Pose.of(pose))

    def current_goal(self, goal: Goal) -> None:
        """Publish the goal that the robot drives to."""
        self._context.publish(topics.MOVE_BASE_CURRENT_GOAL.name, self.stamped(goal.pose))
        self._next_progress = float("-inf")

    def status(self, goals: GoalList[Goal]) -> None:
        """Publish the status of all goals, and of those of other actions under their own action, too."""
        self._context.publish(topics.MOVE_BASE_STATUS.name, status_array(goals, self._context))
        self._through.status(_GoalsOf(goals, lambda goal: goal.many))
        self._along.status(_GoalsOf(goals, lambda goal: bool(goal.path)))

    def feedback(self, goal: Goal, pose: Pose2D, text: str) -> None:
        """Publish the robot's pose as feedback of a goal."""
        status = status_of(goal, Status.ACTIVE, text)
        feedback = MoveBaseFeedback(self.stamped(pose))
        self._context.publish(topics.MOVE_BASE_FEEDBACK.name, MoveBaseActionFeedback(self._header(), status, feedback))

    def progress(self, goal: Goal, pose: Pose2D, progress: GoalProgress, recoveries: int) -> None:
        """Publish the feedback of an action of Nav2, unless it was published less than a period ago."""
        now = self._context.elapsed()
        if now < self._next_progress:
            return
        self._next_progress = now + PROGRESS_PERIOD
        known = (
            self.stamped(pose),
            Duration.of(progress.spent(now)),
            Duration.of(progress.remaining()),
            recoveries,
            progress.distance,
            *progress.tracking_error(pose),
        )
        if goal.path:
            self._along.feedback(goal, self._followed(goal, pose, progress))
            return
        if goal.many:
            statuses = self._waypoints(goal, WaypointProgress.PENDING)
            self._through.feedback(goal, NavigateThroughPosesFeedback(*known, len(goal.through) + 1, statuses))
            return
        status = status_of(goal, Status.ACTIVE, "")
        message = NavigateToPoseActionFeedback(self._header(), status, NavigateToPoseFeedback(*known))
        self._context.publish(topics.NAVIGATE_TO_POSE_FEEDBACK.name, message)

    def _followed(self, goal: Goal, pose: Pose2D, progress: GoalProgress) -> FollowPathFeedback:
        to_end = pose.distance_to(goal.pose)
        tracking = TrackingFeedback(
            self._header(MAP), *progress.tracking_error(pose), progress.index, self.stamped(pose), to_end,
            progress.speed, progress.distance,
        )  # fmt: skip
        return FollowPathFeedback(progress.distance, progress.speed, tracking)

    def result(self, goal: Goal, status: Status, text: str, cause: Trigger | None = None) -> None:
        """Publish the result of a goal by the action by which it came."""
        self.traces.end(goal, status, text)
        if self.on_end is not None:
            self.on_end(goal, status, text)
        if goal.path:
            failed = FollowPathError.UNKNOWN if cause is None else CODES[cause]
            self.path_result(goal, status, text, FollowPathError.NONE if status is Status.SUCCEEDED else failed)
            return
        if goal.many:
            succeeded = status is Status.SUCCEEDED
            code, end = (NONE, WaypointProgress.COMPLETED) if succeeded else (UNKNOWN, WaypointProgress.FAILED)
            statuses = self._waypoints(goal, end)
            self._through.result(goal, status, text, NavigateThroughPosesResult(code, text if code else "", statuses))
            return
        ended = status_of(goal, status, text)
        self._context.publish(topics.MOVE_BASE_RESULT.name, MoveBaseActionResult(self._header(), ended))

    def path_result(self, goal: Goal, status: Status, text: str, code: FollowPathError) -> None:
        """Publish the result of a goal of ``follow_path``."""
        self._along.result(goal, status, text, FollowPathResult(int(code), text if code else ""))

    def _waypoints(self, goal: Goal, rest: WaypointProgress) -> list[WaypointStatus]:
        """Return the statuses of all poses of a goal: those that were passed are completed, the rest as given."""
        listed = [(WaypointProgress.COMPLETED, pose) for pose in goal.passed]
        listed += [(rest, pose) for pose in (*goal.through, goal.pose)]
        return [WaypointStatus(int(state), index, self.stamped(pose)) for index, (state, pose) in enumerate(listed)]


class _GoalsOf:
    """Goals of one action among the goals of Move Base."""

    def __init__(self, goals: GoalList[Goal], belongs: Callable[[Goal], bool]) -> None:
        self._goals, self._belongs = goals, belongs

    def states(self, now: float) -> list[GoalState[Goal]]:
        return [state for state in self._goals.states(now) if self._belongs(state.goal)]
