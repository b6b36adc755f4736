"""Publishers of the actions ``move_base`` and ``navigate_through_poses``: status, feedback and results of goals."""

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Duration, Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import (
    MoveBaseActionFeedback,
    MoveBaseActionResult,
    MoveBaseFeedback,
)
from ppaas.messages.nav2_msgs import (
    NavigateThroughPosesFeedback,
    NavigateThroughPosesResult,
    NavigateToPoseActionFeedback,
    NavigateToPoseFeedback,
    Progress,
    WaypointStatus,
)
from ppaas.navigation.action_goals import GoalList, GoalState
from ppaas.navigation.events import Goal
from ppaas.nodes import topics
from ppaas.nodes.action_publisher import ActionPublisher, status_array, status_of
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP
from ppaas.nodes.move_base.goal_progress import GoalProgress
from ppaas.nodes.nav2_actions import NAVIGATE_THROUGH_POSES

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
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._through: ActionPublisher[Goal] = ActionPublisher(context, NAVIGATE_THROUGH_POSES)
        self._next_progress = float("-inf")

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
        """Publish the status of all goals, and for goals with poses on the way under their own action, too."""
        self._context.publish(topics.MOVE_BASE_STATUS.name, status_array(goals, self._context))
        self._through.status(_WithPoses(goals))

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
        if goal.many:
            statuses = self._waypoints(goal, Progress.PENDING)
            self._through.feedback(goal, NavigateThroughPosesFeedback(*known, len(goal.through) + 1, statuses))
            return
        status = status_of(goal, Status.ACTIVE, "")
        message = NavigateToPoseActionFeedback(self._header(), status, NavigateToPoseFeedback(*known))
        self._context.publish(topics.NAVIGATE_TO_POSE_FEEDBACK.name, message)

    def result(self, goal: Goal, status: Status, text: str) -> None:
        """Publish the result of a goal by the action by which it came."""
        if goal.many:
            succeeded = status is Status.SUCCEEDED
            code, end = (NONE, Progress.COMPLETED) if succeeded else (UNKNOWN, Progress.FAILED)
            statuses = self._waypoints(goal, end)
            self._through.result(goal, status, text, NavigateThroughPosesResult(code, text if code else "", statuses))
            return
        ended = status_of(goal, status, text)
        self._context.publish(topics.MOVE_BASE_RESULT.name, MoveBaseActionResult(self._header(), ended))

    def _waypoints(self, goal: Goal, rest: Progress) -> list[WaypointStatus]:
        """Return the statuses of all poses of a goal: those that were passed are completed, the rest as given."""
        listed = [(Progress.COMPLETED, pose) for pose in goal.passed]
        listed += [(rest, pose) for pose in (*goal.through, goal.pose)]
        return [WaypointStatus(int(state), index, self.stamped(pose)) for index, (state, pose) in enumerate(listed)]


class _WithPoses:
    """Goals of ``navigate_through_poses`` among the goals of Move Base."""

    def __init__(self, goals: GoalList[Goal]) -> None:
        self._goals = goals

    def states(self, now: float) -> list[GoalState[Goal]]:
        return [state for state in self._goals.states(now) if state.goal.many]
