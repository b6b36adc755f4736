"""Node ``waypoint_follower``: drives the robot along a list of waypoints, with the action of Move Base."""

from typing import Annotated, ClassVar

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav2_msgs import (
    FollowWaypointsActionFeedback,
    FollowWaypointsActionGoal,
    FollowWaypointsActionResult,
    FollowWaypointsError,
    FollowWaypointsFeedback,
    FollowWaypointsResult,
    NavigateThroughPosesActionGoal,
    WaypointProgress,
    WaypointStatus,
)
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.navigation.action_goals import GoalList, GoalState, cancels
from ppaas.navigation.events import CancelReceived
from ppaas.navigation.waypoints import Waypoints, check
from ppaas.nodes import topics
from ppaas.nodes.action_publisher import status_array, status_of
from ppaas.nodes.base import Context, Demands, Node, Payload, Timer, Topic
from ppaas.nodes.frames import MAP, FrameListener
from ppaas.nodes.key_frame_path import key_frames_of
from ppaas.nodes.message_checks import pose_in
from ppaas.nodes.nav2_actions import NAVIGATE_THROUGH_POSES
from ppaas.parameters import Parameters

# -- publishers of the action ``follow_waypoints`` ---------------------------------------------------------------------


class WaypointTopics:
    """Publishes status, feedback and results of lists of waypoints.

    Parameters
    ----------
    context : Context
        The node's context.
    """

    def __init__(self, context: Context) -> None:
        self._context = context

    def _header(self) -> Header:
        return Header(stamp=Time.of(self._context.now()))

    def status(self, lists: GoalList[Waypoints]) -> None:
        """Publish the status of all lists."""
        self._context.publish(topics.WAYPOINTS_STATUS.name, status_array(lists, self._context))

    def feedback(self, state: GoalState[Waypoints]) -> None:
        """Publish the waypoint that the robot drives to."""
        status = status_of(state.goal, Status.ACTIVE, state.text)
        feedback = FollowWaypointsActionFeedback(self._header(), status, FollowWaypointsFeedback(state.goal.index))
        self._context.publish(topics.WAYPOINTS_FEEDBACK.name, feedback)

    def result(self, ended: GoalState[Waypoints], error: FollowWaypointsError) -> None:
        """Publish the result of a list."""
        waypoints = ended.goal
        missed = [
            WaypointStatus(
                WaypointProgress.FAILED,
                missed.index,
                PoseStamped(Header(frame_id=MAP), Pose.of(waypoints.poses[missed.index])),
                FollowWaypointsError.UNKNOWN,
                missed.reason,
            )
            for missed in sorted(waypoints.missed, key=lambda each: each.index)
        ]
        result = FollowWaypointsResult(missed, int(error), ended.text if error else "")
        status = status_of(waypoints, ended.status, ended.text)
        self._context.publish(topics.WAYPOINTS_RESULT.name, FollowWaypointsActionResult(self._header(), status, result))


# -- node ``waypoint_follower`` ----------------------------------------------------------------------------------------

STATUS_PERIOD = 1.0


class WaypointFollowerParameters(Parameters, frozen=True):
    """Parameters of the waypoint follower, named as in Nav2.

    Parameters
    ----------
    stop_on_failure : bool
        Whether a waypoint that cannot be reached ends the list; otherwise the next one is tried.
    loop_rate : float
        Rate of feedback [Hz]. Nav2 also polls for results at this rate; here results are received as messages.
    waypoint_pause_duration : int
        Time for which the robot stands at each waypoint that it has reached [ms].
    """

    stop_on_failure: bool = True
    loop_rate: Annotated[float, msgspec.Meta(gt=0.0, le=100.0)] = 1.0
    waypoint_pause_duration: Annotated[int, msgspec.Meta(ge=0, le=86_400_000)] = 0


class WaypointFollowerState(msgspec.Struct):
    """Checkpoint of the waypoint follower."""

    waypoints: Waypoints | None
    counter: int


class WaypointFollowerNode(Node):
    """Serves Nav2's action ``follow_waypoints`` by the topics of a ROS 1 action.

    One list is followed at once; a new list replaces it. Another goal for Move Base, or a cancel of its goal by a
    client, ends the list too.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : WaypointFollowerParameters
        Named as in Nav2.
    """

    name: ClassVar[str] = "waypoint_follower"
    demands: ClassVar[Demands] = Demands(0.02)
    subscribes: ClassVar[tuple[Topic, ...]] = (
        topics.WAYPOINTS_GOAL, topics.WAYPOINTS_CANCEL,
        topics.MOVE_BASE_GOAL, topics.SIMPLE_GOAL, topics.GOAL_POSE, topics.MOVE_BASE_CANCEL, topics.MOVE_BASE_RESULT,
        topics.TF, topics.TF_STATIC, NAVIGATE_THROUGH_POSES.goal,
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
        """Whether a list is active."""
        return self._lists.active is not None

    def start(self) -> None:
        """Start publishing the status of lists."""
        self.context.every(STATUS_PERIOD, lambda: self._topics.status(self._lists))

    # -- messages ------------------------------------------------------------------------------------------------------

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message; an invalid list does not affect the active one.

        Raises
        ------
        InvalidInput
            A list is empty or too long, or a waypoint is not finite or has no frame.
        TransformError
            The frame of a waypoint is unknown.
        """
        now = self.context.elapsed()
        match message:
            case TFMessage():
                self._frames.hear(topic, message, now, self.context.now())
            case MoveBaseActionResult():
                self._on_result(message.status)
            case MoveBaseActionGoal():
                self._on_other_goal(message.goal.target_pose, message.goal_id.id)
            case PoseStamped():
                self._on_other_goal(message, "")
            case NavigateThroughPosesActionGoal():
                for pose in message.goal.poses[-1:]:
                    self._on_other_goal(pose, message.goal_id.id)
            case GoalID() if topic == topics.WAYPOINTS_CANCEL.name:
                self._on_cancel(CancelReceived(now, message.id, message.stamp.seconds()))
            case GoalID():
                self._on_other_cancel(CancelReceived(now, message.id, message.stamp.seconds()))
            case FollowWaypointsActionGoal():
                self._on_list(message)
            case _:
                raise InvalidInput(f"{self.name} does not accept {type(message).__name__} on topic {topic!r}")

    def _on_list(self, message: FollowWaypointsActionGoal) -> None:
        goal = message.goal
        if self._lists.knows(message.goal_id.id, self.context.elapsed()):
            return
        check(len(goal.poses), goal.number_of_loops, goal.goal_index)
        tree = self._frames.tree
        poses = [pose_in(tree, MAP, pose, f"waypoint {index}") for index, pose in enumerate(goal.poses)]
        stamp = message.goal_id.stamp.seconds() or self.context.now()
        self._counter += 1
        name = message.goal_id.id or f"{self.name}-{self._counter}-{stamp:.3f}"
        if self._lists.active is not None:
            self._end(Status.PREEMPTED, f"Replaced by another list: {name}")
        self._follow(Waypoints(name, stamp, poses, goal.number_of_loops, goal.goal_index))

    def _on_cancel(self, event: CancelReceived) -> None:
        active = self._lists.active
        if active is None or not self._lists.cancelled_by(event):
            return
        # Ended before Move Base's goal is cancelled, whose result would otherwise look like a cancel by a client.
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
            self._preempt(status.text)

    def _on_missed(self, waypoints: Waypoints, reason: str) -> None:
        if self._parameters.stop_on_failure:
            text = f"Waypoint {waypoints.index} could not be reached: {reason}"
            self._end(Status.ABORTED, text, FollowWaypointsError.STOP_ON_MISSED_WAYPOINT)
        else:
            self._go_on(waypoints)

    # -- goals of other clients ----------------------------------------------------------------------------------------

    def _on_other_goal(self, target: PoseStamped, goal_id: str) -> None:
        """End the list for a client's goal during a pause; at other times, the result of our own goal shows it."""
        active = self._lists.active
        if active is None or not active.goal.pausing or goal_id == active.goal.goal.id:
            return
        pose_in(self._frames.tree, MAP, target, "a goal")
        self._preempt(f"Replaced by another goal: {goal_id or 'a simple goal'}")

    def _on_other_cancel(self, event: CancelReceived) -> None:
        active = self._lists.active
        if active is not None and active.goal.pausing and cancels(event, active.goal.goal):
            self._preempt("The goal was cancelled.")

    def _preempt(self, reason: str) -> None:
        active = self._lists.active
        assert active is not None
        text = f"The list ended at waypoint {active.goal.index}: {reason}"
        self._end(Status.PREEMPTED, text, FollowWaypointsError.UNKNOWN)

    # -- following the list --------------------------------------------------------------------------------------------

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
        ended = self._lists.end(self.context.elapsed(), status, text)
        self._topics.result(ended, error)
        self._topics.status(self._lists)

    # -- checkpoints ---------------------------------------------------------------------------------------------------

    def checkpoint(self) -> bytes:
        """Return the active list with its progress, as JSON."""
        active = self._lists.active
        return msgspec.json.encode(WaypointFollowerState(active.goal if active else None, self._counter))

    def restore(self, state: bytes) -> None:
        """Continue to the waypoint of a checkpoint; a pause starts again.

        Move Base may have been restored to the same goal; it ignores a goal with a known id.
        """
        restored = from_json(state, WaypointFollowerState)
        self._counter = restored.counter
        if restored.waypoints is not None:
            self._follow(restored.waypoints)

    def carry_over(self, state: bytes) -> None:
        """End the list of a checkpoint, whose waypoints are poses on another map."""
        restored = from_json(state, WaypointFollowerState)
        self._counter = restored.counter
        if restored.waypoints is not None:
            self._lists.accept(restored.waypoints)
            self._end(Status.PREEMPTED, "The robot is on another map now.")


# -- node ``waypoint_follower`` of a robot that makes its map ----------------------------------------------------------


class MappingWaypointFollowerNode(WaypointFollowerNode):
    """Waypoint follower of a robot that makes its map: waypoints move with the key frames that are nearest to them.

    Move Base moves the waypoint that the robot drives to, once the map shows the moved key frames.

    Parameters
    ----------
    context : Context
        The node's context.
    parameters : WaypointFollowerParameters
        Named as in Nav2.
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (*WaypointFollowerNode.subscribes, topics.KEY_FRAMES)

    def __init__(self, context: Context, parameters: WaypointFollowerParameters) -> None:
        super().__init__(context, parameters)
        self._key_frames = NO_KEY_FRAMES

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message; raises as the waypoint follower's method does."""
        if topic != topics.KEY_FRAMES.name:
            super().on_message(topic, message)
            return
        before, after = self._key_frames, key_frames_of(message)
        self._key_frames = after
        active = self._lists.active
        if active is not None and len(before) and len(after) and after.differs(before):
            active.goal.poses = [after.carry(pose, before) for pose in active.goal.poses]
