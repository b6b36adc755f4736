"""Goals that the node ``follow_person`` sends to Move Base, and clients' goals, which take precedence."""

from enum import Enum

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav2_motions import FollowPathActionGoal
from ppaas.messages.nav2_msgs import NavigateThroughPosesActionGoal
from ppaas.messages.people_coordination import GoalUpdate
from ppaas.navigation.action_goals import cancels
from ppaas.navigation.events import CancelReceived, Goal
from ppaas.navigation.goal_watch import GoalWatch
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Payload, Topic
from ppaas.nodes.frames import MAP
from ppaas.nodes.nav2_actions import BACKUP, DRIVE_ON_HEADING, FOLLOW_PATH, NAVIGATE_THROUGH_POSES, SPIN, WAIT
from ppaas.people.names import FOLLOWING_GOAL

MOVED, TURNED, FASTER = 0.1, 0.2, 0.03
"""Changes of a goal below which it is not updated [m, rad, m/s]."""

LATE = 1.0
"""Time within which a client's goal appears in the status list [s]."""


class MoveOutcome(Enum):
    """End of a goal of the node, or what a client did."""

    REACHED = "reached"
    FAILED = "failed"
    PREEMPTED = "preempted"
    CANCELLED = "cancelled"


class MoveBaseLink:
    """Sends one goal at once, moves it, and knows whether a client has goals.

    Parameters
    ----------
    context : Context
        Of the node.
    period : float
        Least time between two updates of the place of a goal [s]; its heading is updated at once.

    Attributes
    ----------
    counter : int
        Number of goals sent; part of their ids.
    text : str
        Text of the last result.
    """

    subscribes: tuple[Topic, ...] = (
        topics.MOVE_BASE_GOAL, topics.SIMPLE_GOAL, topics.GOAL_POSE, NAVIGATE_THROUGH_POSES.goal,
        topics.MOVE_BASE_CANCEL, topics.MOVE_BASE_RESULT, topics.MOVE_BASE_STATUS, topics.WAYPOINTS_STATUS,
        SPIN.status, BACKUP.status, DRIVE_ON_HEADING.status, WAIT.status, FOLLOW_PATH.goal,
    )  # fmt: skip
    publishes: tuple[Topic, ...] = (topics.MOVE_BASE_GOAL, topics.MOVE_BASE_GOAL_UPDATE, topics.MOVE_BASE_CANCEL)

    def __init__(self, context: Context, period: float = 0.0) -> None:
        self._context, self._period = context, period
        self.counter, self.text = 0, ""
        self._goal: Goal | None = None
        self._watch = GoalWatch("")
        self._speed = 0.0
        self._updated_at = float("-inf")
        self._clients: set[str] = set()
        self._heard = False
        self._expected_until = float("-inf")
        self._last_client = float("-inf")

    @property
    def driving(self) -> bool:
        """Whether Move Base has a goal of the node."""
        return self._goal is not None

    @property
    def has_client(self) -> bool:
        """Whether a client has a goal."""
        return bool(self._clients) or self._context.elapsed() < self._expected_until

    @property
    def is_heard(self) -> bool:
        """Whether Move Base has reported its goals."""
        return self._heard

    def is_free(self, delay: float) -> bool:
        """Return whether no client has had a goal for a time [s], as far as Move Base has reported."""
        now = self._context.elapsed()
        if self.has_client:
            self._last_client = now
        return self._heard and now - self._last_client >= delay

    # -- goals of the node ---------------------------------------------------------------------------------------------

    def drive(self, pose: Pose2D, speed: float) -> None:
        """Drive to a pose, at most at a speed [m/s], 0 for no limit: the goal is moved, or a new one is sent."""
        goal = self._goal
        if goal is None:
            self._send(pose)
            if speed > 0.0:
                self._update(pose, speed)
            return
        turned = abs(wrap_angle(goal.pose.theta - pose.theta)) > TURNED
        moved = goal.pose.distance_to(pose) > MOVED
        if not (turned or moved or abs(speed - self._speed) > FASTER):
            return
        if (moved or not turned) and self._context.elapsed() - self._updated_at < self._period:
            return
        self._goal = Goal(goal.id, pose, goal.stamp)
        self._update(pose, speed)

    def stop(self) -> None:
        """Cancel the goal of the node, if there is one; its result is ignored."""
        goal, self._goal = self._goal, None
        if goal is not None:
            self._context.publish(topics.MOVE_BASE_CANCEL.name, GoalID(id=goal.id))

    def _send(self, pose: Pose2D) -> None:
        self.counter += 1
        stamp = self._context.now()
        self._goal = Goal(f"{FOLLOWING_GOAL}{self.counter}-{stamp:.3f}", pose, stamp)
        self._watch, self._speed = GoalWatch(self._goal.id), 0.0
        goal_id = GoalID(Time.of(stamp), self._goal.id)
        self._context.publish(
            topics.MOVE_BASE_GOAL.name, MoveBaseActionGoal(MoveBaseGoal(self._stamped(pose)), goal_id)
        )

    def _update(self, pose: Pose2D, speed: float) -> None:
        if self._goal is None:
            return  # Move Base has refused the goal that was just sent
        self._speed, self._updated_at = speed, self._context.elapsed()
        update = GoalUpdate(self._goal.id, self._stamped(pose), speed)
        self._context.publish(topics.MOVE_BASE_GOAL_UPDATE.name, update)

    def _stamped(self, pose: Pose2D) -> PoseStamped:
        return PoseStamped(Header(stamp=Time.of(self._context.now()), frame_id=MAP), Pose.of(pose))

    # -- messages ------------------------------------------------------------------------------------------------------

    def take(self, topic: str, message: Payload) -> MoveOutcome | None:
        """Take a message of one of the topics; return what it means for following, None for nothing."""
        match message:
            case MoveBaseActionResult():
                return self._on_result(message)
            case GoalStatusArray():
                self._on_status(topic, message)
            case MoveBaseActionGoal() | NavigateThroughPosesActionGoal() | FollowPathActionGoal():
                self._on_goal(message.goal_id.id)
            case PoseStamped():
                self._on_goal("")
            case GoalID():
                return self._on_cancel(message)
        return None

    def _on_result(self, message: MoveBaseActionResult) -> MoveOutcome | None:
        status = message.status
        if self._goal is None or status.goal_id.id != self._goal.id:
            return None
        self._goal, self.text = None, status.text
        if status.status == Status.SUCCEEDED:
            return MoveOutcome.REACHED
        if status.status == Status.ABORTED:
            return MoveOutcome.FAILED
        self._expected_until = self._context.elapsed() + LATE
        return MoveOutcome.PREEMPTED

    def _on_status(self, topic: str, message: GoalStatusArray) -> None:
        active = [each.goal_id.id for each in message.status_list if not Status(each.status).terminal]
        if any(not goal_id.startswith(FOLLOWING_GOAL) for goal_id in active):
            self._clients.add(topic)
        else:
            self._clients.discard(topic)
        if topic != topics.MOVE_BASE_STATUS.name:
            return
        if not self._heard:
            for goal_id in active:
                self._cancel_earlier(goal_id)
        self._heard = True
        if self._goal is not None and self._watch.see(message.status_list, self._context.elapsed()) is not None:
            self._goal = None  # its result was lost, or Move Base was replaced by one that does not know it

    def _cancel_earlier(self, goal_id: str) -> None:
        """Cancel a goal that this node sent before it was restarted, for an order that may be gone."""
        if goal_id.startswith(FOLLOWING_GOAL):
            self._context.publish(topics.MOVE_BASE_CANCEL.name, GoalID(id=goal_id))

    def _on_goal(self, goal_id: str) -> None:
        if not goal_id.startswith(FOLLOWING_GOAL):
            self._expected_until = self._context.elapsed() + LATE

    def _on_cancel(self, message: GoalID) -> MoveOutcome | None:
        """Return whether a client cancels the goal of the node, or all goals, which stops the robot."""
        event = CancelReceived(self._context.elapsed(), message.id, message.stamp.seconds())
        everything = not event.id and event.stamp == 0.0
        own = self._goal is not None and cancels(event, self._goal)
        return MoveOutcome.CANCELLED if everything or own else None
