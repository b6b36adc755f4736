"""The waypoint follower as a node: drives the robot along a list of goals, by the action of Move Base."""

from typing import Annotated, ClassVar

import msgspec

from ppaas.errors import InvalidInput
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav2_msgs import FollowWaypointsActionGoal, FollowWaypointsError
from ppaas.messages.std_msgs import Header, Time
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.navigation.action_goals import GoalList, cancels
from ppaas.navigation.events import CancelReceived
from ppaas.navigation.waypoints import Waypoints, check
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Demands, Node, Payload, Timer, Topic
from ppaas.nodes.frames import MAP, FrameListener
from ppaas.nodes.message_checks import pose_in
from ppaas.nodes.waypoint_follower.action_topics import WaypointTopics
from ppaas.parameters import Parameters

STATUS_PERIOD = 1.0


class WaypointFollowerParameters(Parameters, frozen=True):
    """Parameters of the waypoint follower, with the names of Nav2's.

    Parameters
    ----------
    stop_on_failure : bool
        Whether a waypoint that cannot be reached ends the list; else the next is tried.
    loop_rate : float
        How often it tells which waypoint the robot drives to [Hz]. Nav2's looks for results as often; this one is told.
    waypoint_pause_duration : int
        How long the robot stands at each waypoint that it reached [ms].
    """

    stop_on_failure: bool = True
    loop_rate: Annotated[float, msgspec.Meta(gt=0.0, le=100.0)] = 1.0
    waypoint_pause_duration: Annotated[int, msgspec.Meta(ge=0, le=86_400_000)] = 0


class WaypointFollowerState(msgspec.Struct):
    """What the follower needs to go on elsewhere."""

    waypoints: Waypoints | None
    counter: int


class WaypointFollowerNode(Node):
    """Offers the action ``follow_waypoints``: Nav2's, by the topics of an action of ROS 1.

    One list is followed at a time; a new one takes the place of the old. Who gives Move Base another goal, or cancels
    the one under way, means the robot: that ends the list too.

    Parameters
    ----------
    context : Context
        Of its home.
    parameters : WaypointFollowerParameters
        With the names of Nav2.
    """

    name: ClassVar[str] = "waypoint_follower"
    demands: ClassVar[Demands] = Demands(0.02)
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.WAYPOINTS_GOAL, topics.WAYPOINTS_CANCEL,
        topics.MOVE_BASE_GOAL, topics.SIMPLE_GOAL, topics.MOVE_BASE_CANCEL, topics.MOVE_BASE_RESULT,
        topics.TF, topics.TF_STATIC,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        topics.WAYPOINTS_STATUS, topics.WAYPOINTS_FEEDBACK, topics.WAYPOINTS_RESULT,
        topics.MOVE_BASE_GOAL, topics.MOVE_BASE_CANCEL,
    )  # fmt: skip

    def __init__(self, context: Context, parameters: WaypointFollowerParameters) -> None:
        super().__init__(context)
        self._parameters = parameters
        self._topics = WaypointTopics(context)
        self._frames = FrameListener()
        self._lists: GoalList[Waypoints] = GoalList()
        self._timers: list[Timer] = []
        self._counter = 0

    @property
    def busy(self) -> bool:
        """Tell whether there is a list."""
        return self._lists.active is not None

    def start(self) -> None:
        """Begin to tell how lists stand."""
        self.context.every(STATUS_PERIOD, lambda: self._topics.status(self._lists))

    # -- what comes in -------------------------------------------------------------------------------------------------

    def on_message(self, topic: str, message: Payload) -> None:
        """Take a message; a list that cannot be taken does not disturb the one under way.

        Raises
        ------
        InvalidInput
            A list without waypoints, or with too many; a waypoint that is not finite or without a frame.
        TransformError
            The frame of a waypoint is not known.
        """
        now = self.context.now()
        match message:
            case TFMessage():
                self._frames.hear(topic, message, now)
            case MoveBaseActionResult():
                self._on_result(message.status)
            case MoveBaseActionGoal():
                self._on_other_goal(message.goal.target_pose, message.goal_id.id)
            case PoseStamped():
                self._on_other_goal(message, "")
            case GoalID() if topic == topics.WAYPOINTS_CANCEL.name:
                self._on_cancel(CancelReceived(now, message.id, message.stamp.seconds()))
            case GoalID():
                self._on_other_cancel(CancelReceived(now, message.id, message.stamp.seconds()))
            case FollowWaypointsActionGoal():
                self._on_list(message)
            case _:
                raise InvalidInput(f"{self.name} takes no {type(message).__name__} on {topic!r}")

    def _on_list(self, message: FollowWaypointsActionGoal) -> None:
        now, goal = self.context.now(), message.goal
        if self._lists.knows(message.goal_id.id, now):
            return
        check(len(goal.poses), goal.number_of_loops, goal.goal_index)
        tree = self._frames.tree
        poses = [pose_in(tree, MAP, pose, f"waypoint {index}") for index, pose in enumerate(goal.poses)]
        stamp = message.goal_id.stamp.seconds() or now
        self._counter += 1
        name = message.goal_id.id or f"{self.name}-{self._counter}-{stamp:.3f}"
        if self._lists.active is not None:
            self._end(Status.PREEMPTED, f"Another list took its place: {name}")
        self._follow(Waypoints(name, stamp, poses, goal.number_of_loops, goal.goal_index))

    def _on_cancel(self, event: CancelReceived) -> None:
        active = self._lists.active
        if active is None or not self._lists.cancelled_by(event):
            return
        # First, or Move Base's word that the goal is cancelled would seem to come of others.
        self._end(Status.PREEMPTED, "The list was cancelled.")
        self.context.publish(topics.MOVE_BASE_CANCEL.name, GoalID(id=active.goal.goal.id))

    def _on_result(self, status: GoalStatus) -> None:
        active = self._lists.active
        if active is None or active.goal.pausing or status.goal_id.id != active.goal.goal.id:
            return
        waypoints = active.goal
        if status.status == Status.SUCCEEDED:
            waypoints.reach()
            self._pause(waypoints)
        elif status.status == Status.ABORTED:
            waypoints.miss(status.text)
            self._on_missed(waypoints, status.text)
        else:
            self._taken_away(status.text)

    def _on_missed(self, waypoints: Waypoints, reason: str) -> None:
        if self._parameters.stop_on_failure:
            text = f"Waypoint {waypoints.index} could not be reached: {reason}"
            self._end(Status.ABORTED, text, FollowWaypointsError.STOP_ON_MISSED_WAYPOINT)
        else:
            self._go_on(waypoints)

    # -- others who want the robot -------------------------------------------------------------------------------------

    def _on_other_goal(self, target: PoseStamped, goal_id: str) -> None:
        """Heed a goal that somebody gives Move Base while it has none of ours; else its result will tell."""
        active = self._lists.active
        if active is None or not active.goal.pausing or goal_id == active.goal.goal.id:
            return
        pose_in(self._frames.tree, MAP, target, "a goal")
        self._taken_away(f"Another goal took its place: {goal_id or 'a simple goal'}")

    def _on_other_cancel(self, event: CancelReceived) -> None:
        active = self._lists.active
        if active is not None and active.goal.pausing and cancels(event, active.goal.goal):
            self._taken_away("The goal was cancelled.")

    def _taken_away(self, reason: str) -> None:
        active = self._lists.active
        assert active is not None
        text = f"The list ended at waypoint {active.goal.index}: {reason}"
        self._end(Status.PREEMPTED, text, FollowWaypointsError.UNKNOWN)

    # -- going along the list ------------------------------------------------------------------------------------------

    def _follow(self, waypoints: Waypoints) -> None:
        self._lists.accept(waypoints)
        self._timers.append(self.context.every(1.0 / self._parameters.loop_rate, self._tell))
        if waypoints.pausing:
            self._pause(waypoints)
        else:
            self._drive(waypoints)

    def _drive(self, waypoints: Waypoints) -> None:
        self._say(f"driving to waypoint {waypoints.index}")
        goal = waypoints.goal
        target = PoseStamped(Header(stamp=Time.of(self.context.now()), frame_id=MAP), Pose.of(goal.pose))
        goal_id = GoalID(Time.of(goal.stamp), goal.id)
        self.context.publish(topics.MOVE_BASE_GOAL.name, MoveBaseActionGoal(MoveBaseGoal(target), goal_id))

    def _pause(self, waypoints: Waypoints) -> None:
        seconds = self._parameters.waypoint_pause_duration / 1000.0
        if seconds == 0.0:
            self._go_on(waypoints)
            return
        waypoints.pausing = True

        def over() -> None:
            timer.stop()
            if self._lists.active is not None and self._lists.active.goal is waypoints:
                self._go_on(waypoints)

        timer = self.context.every(seconds, over)
        self._say(f"pausing at waypoint {waypoints.index}")

    def _go_on(self, waypoints: Waypoints) -> None:
        if waypoints.go_on():
            self._drive(waypoints)
        elif len(waypoints.missed) == len(waypoints.poses):
            self._end(
                Status.ABORTED, "None of the waypoints could be reached.", FollowWaypointsError.NO_VALID_WAYPOINTS
            )
        else:
            missed = f" {len(waypoints.missed)} missed." if waypoints.missed else ""
            self._end(Status.SUCCEEDED, f"The list is done.{missed}")

    def _say(self, text: str) -> None:
        assert self._lists.active is not None
        self._lists.active.text = text
        self._topics.status(self._lists)
        self._tell()

    def _tell(self) -> None:
        if self._lists.active is not None:
            self._topics.feedback(self._lists.active)

    def _end(self, status: Status, text: str, error: FollowWaypointsError = FollowWaypointsError.NONE) -> None:
        for timer in self._timers:
            timer.stop()
        self._timers.clear()
        ended = self._lists.end(self.context.now(), status, text)
        self._topics.result(ended, error)
        self._topics.status(self._lists)

    # -- going on elsewhere --------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the list under way, and how far the robot is with it."""
        active = self._lists.active
        return msgspec.json.encode(WaypointFollowerState(active.goal if active else None, self._counter))

    def restore(self, state: bytes) -> None:
        """Go on with the waypoint that the robot drove to; a pause begins anew.

        Move Base may have been restored to the same goal: it has the same id, and is not begun twice.
        """
        restored = msgspec.json.decode(state, type=WaypointFollowerState)
        self._counter = restored.counter
        if restored.waypoints is not None:
            self._follow(restored.waypoints)
