"""Publishers of the action ``move_base``: status, feedback and results of goals."""

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import (
    MoveBaseActionFeedback,
    MoveBaseActionResult,
    MoveBaseFeedback,
)
from ppaas.messages.nav2_msgs import NavigateToPoseActionFeedback, NavigateToPoseFeedback
from ppaas.messages.std_msgs import Duration, Header, Time
from ppaas.navigation.action_goals import GoalList
from ppaas.navigation.events import Goal
from ppaas.nodes import topics
from ppaas.nodes.action_publisher import status_array, status_of
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP
from ppaas.nodes.move_base.goal_progress import GoalProgress

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
        """Publish the status of all goals."""
        self._context.publish(topics.MOVE_BASE_STATUS.name, status_array(goals, self._context))

    def feedback(self, goal: Goal, pose: Pose2D, text: str) -> None:
        """Publish the robot's pose as feedback of a goal."""
        status = status_of(goal, Status.ACTIVE, text)
        feedback = MoveBaseFeedback(self.stamped(pose))
        self._context.publish(topics.MOVE_BASE_FEEDBACK.name, MoveBaseActionFeedback(self._header(), status, feedback))

    def progress(self, goal: Goal, pose: Pose2D, progress: GoalProgress, recoveries: int) -> None:
        """Publish the feedback of ``navigate_to_pose``, unless it was published less than a period ago."""
        now = self._context.elapsed()
        if now < self._next_progress:
            return
        self._next_progress = now + PROGRESS_PERIOD
        feedback = NavigateToPoseFeedback(
            self.stamped(pose),
            Duration.of(progress.spent(now)),
            Duration.of(progress.remaining()),
            recoveries,
            progress.distance,
        )
        message = NavigateToPoseActionFeedback(self._header(), status_of(goal, Status.ACTIVE, ""), feedback)
        self._context.publish(topics.NAVIGATE_TO_POSE_FEEDBACK.name, message)

    def result(self, goal: Goal, status: Status, text: str) -> None:
        """Publish the result of a goal."""
        ended = status_of(goal, status, text)
        self._context.publish(topics.MOVE_BASE_RESULT.name, MoveBaseActionResult(self._header(), ended))
