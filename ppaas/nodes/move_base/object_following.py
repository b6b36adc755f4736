"""Action ``follow_object`` of Nav2: Move Base drives after a frame, or after the poses of a topic, by a moving goal."""

import math
from collections.abc import Callable
from typing import ClassVar, NamedTuple, Protocol

import msgspec

from ppaas.errors import InvalidInput, PPaaSError, TransformError
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Duration, Time
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.nav2_motions import (
    FollowObjectActionGoal,
    FollowObjectError,
    FollowObjectFeedback,
    FollowObjectGoal,
    FollowObjectPhase,
    FollowObjectResult,
)
from ppaas.navigation.action_goals import GoalList, cancels
from ppaas.navigation.events import CancelReceived, Goal
from ppaas.nodes import topics
from ppaas.nodes.action_publisher import ActionPublisher
from ppaas.nodes.base import Context, Payload, Timer, Topic
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import expect, pose_in
from ppaas.nodes.move_base.goal_progress import ActionTopics
from ppaas.nodes.move_base.surroundings import Surroundings
from ppaas.nodes.nav2_actions import FOLLOW_OBJECT

DISTANCE = 1.0
"""Distance from the object at which the robot stops, ``desired_distance`` of Nav2's following server [m]."""

FRESH, LOST = 2.0, 10.0
"""Age up to which a pose of the object counts, and time without one after which the goal fails [s]."""

PERIOD, FEEDBACK_PERIOD = 0.2, 0.5
"""Periods of decisions, and of feedback [s]."""

NEAR, FACING = 0.3, 0.5
"""Differences to its place behind the object beyond which a standing robot drives again [m, rad]."""

MOVED, TURNED = 0.1, 0.2
"""Changes of that place below which the goal of a driving robot is not moved [m, rad]."""

RETRIES = 3
"""Number of goals of Move Base that may fail before the action does, ``max_retries`` of Nav2."""

PREFIX = "follow_object/"
"""Beginning of the ids of the goals of Move Base."""


class ObjectGoal(msgspec.Struct, frozen=True):
    """Object to follow; checkpoints contain it as JSON.

    Parameters
    ----------
    id, stamp
        As of any action's goal.
    frame : str
        Its frame; empty if its poses come by a topic.
    max_duration : float
        Time limit [s]; 0 for none.
    seconds : float
        Time for which it was followed before this executor [s].
    """

    id: str
    stamp: float
    frame: str = ""
    max_duration: float = 0.0
    seconds: float = 0.0


class Seen(NamedTuple):
    """Where the object was seen, and when [s]."""

    pose: Pose2D
    at: float


class DrivenRobot(Protocol):
    """Move Base, as the part that follows objects drives it."""

    def drive_to(self, pose: Pose2D, goal_id: GoalID) -> None:
        """Drive to a pose in the map frame, in place of the goal before."""
        ...

    def move_goal(self, pose: Pose2D) -> None:
        """Move the goal that the robot drives to."""
        ...

    def end_goal(self, reason: str) -> None:
        """End the goal that the robot drives to."""
        ...


class ObjectFollower:
    """Serves the action: at most one goal, which any other goal, behaviour or cancel of all goals ends.

    Parameters
    ----------
    context : Context
        Context of the node that serves it.
    surroundings : Surroundings
        Pose and frames of the robot.
    robot : DrivenRobot
    ends : ActionTopics
        Publishes the ends of Move Base's goals.
    """

    subscribes: ClassVar[tuple[Topic, ...]] = (*FOLLOW_OBJECT[:2], topics.DYNAMIC_POSE)
    publishes: ClassVar[tuple[Topic, ...]] = FOLLOW_OBJECT[2:]

    def __init__(self, context: Context, surroundings: Surroundings, robot: DrivenRobot, ends: ActionTopics) -> None:
        ends.on_end = self.ended
        self._context, self._surroundings, self._robot = context, surroundings, robot
        self._goals: GoalList[ObjectGoal] = GoalList()
        self._publisher: ActionPublisher[ObjectGoal] = ActionPublisher(context, FOLLOW_OBJECT)
        self._timer: Timer | None = None
        self._began = self._fed_back = 0.0
        self._seen: Seen | None = None
        self._lost_since = 0.0
        self._driving: Goal | None = None
        self._phase = FollowObjectPhase.NONE
        self._retries = self._counter = 0
        self._handlers: dict[str, Callable[[Payload], None]] = {
            FOLLOW_OBJECT.goal.name: self._on_goal,
            FOLLOW_OBJECT.cancel.name: self._on_cancel,
            topics.DYNAMIC_POSE.name: self._on_pose,
        }

    @property
    def active(self) -> bool:
        """True while an object is followed."""
        return self._goals.active is not None

    def take(self, topic: str, message: Payload) -> bool:
        """Handle a message of one of the topics; return whether it is of one."""
        handle = self._handlers.get(topic)
        if handle is not None:
            handle(message)
        return handle is not None

    def publish_statuses(self) -> None:
        """Publish the statuses of all goals."""
        self._publisher.status(self._goals)

    # -- goals ---------------------------------------------------------------------------------------------------------

    def _on_goal(self, message: Payload) -> None:
        request = expect(message, FollowObjectActionGoal)
        now = self._context.elapsed()
        stamp = request.goal_id.stamp.seconds() or self._context.now()
        self._counter += 1
        goal = ObjectGoal(request.goal_id.id or f"object-{self._counter}-{stamp:.3f}", stamp)
        if self._goals.knows(goal.id, now):
            return
        try:
            goal = msgspec.structs.replace(goal, frame=_frame_of(request.goal), max_duration=_limit_of(request.goal))
        except InvalidInput as error:
            self._goals.refuse(goal, now, str(error))
            self._publish_end(goal, Status.ABORTED, str(error), FollowObjectError.UNKNOWN)
            return
        self.replaced(f"Replaced by another goal: {goal.id}")
        self._begin(goal)

    def _begin(self, goal: ObjectGoal) -> None:
        now = self._context.elapsed()
        self._goals.accept(goal)
        self._began, self._lost_since, self._retries = now - goal.seconds, now, 0
        self._seen, self._driving, self._phase = None, None, FollowObjectPhase.INITIAL_PERCEPTION
        self._timer = self._context.every(PERIOD, self._step)
        self._publisher.status(self._goals)
        self._step()

    def _on_cancel(self, message: Payload) -> None:
        cancel = expect(message, GoalID)
        self.cancel(CancelReceived(self._context.elapsed(), cancel.id, cancel.stamp.seconds()))

    def cancel(self, event: CancelReceived) -> None:
        """Cancel the goal if the event applies to it."""
        active = self._goals.active
        if active is not None and cancels(event, active.goal):
            self._end(Status.PREEMPTED, "The goal was cancelled.")

    def replaced(self, reason: str) -> None:
        """End the goal, because the robot does something else."""
        self._end(Status.PREEMPTED, reason)

    def ended(self, goal: Goal, status: Status, text: str) -> None:
        """Take the end of a goal of Move Base."""
        if self._driving is None or goal.id != self._driving.id:
            return
        self._driving = None
        if status is Status.SUCCEEDED:
            return
        if status is not Status.ABORTED:
            self._end(Status.PREEMPTED, text)
        elif self._retries >= RETRIES:
            self._end(Status.ABORTED, text, FollowObjectError.FAILED_TO_CONTROL)
        else:
            self._retries += 1
            self._phase = FollowObjectPhase.RETRY

    # -- the object ----------------------------------------------------------------------------------------------------

    def _on_pose(self, message: Payload) -> None:
        active = self._goals.active
        if active is not None and not active.goal.frame:
            tree = self._surroundings.frames.tree
            pose = pose_in(tree, MAP, expect(message, PoseStamped), "the pose of the object")
            self._seen = Seen(pose, self._context.elapsed())

    def _look(self, goal: ObjectGoal, now: float) -> Pose2D | None:
        """Return where the object is; None if it was not seen lately."""
        frames = self._surroundings.frames
        if goal.frame:
            silence = 0.0 if frames.tree.newest(goal.frame) is None else frames.silence(goal.frame, now)
            try:
                self._seen = Seen(frames.tree.lookup(MAP, goal.frame), now - silence)
            except TransformError:
                return None
        return self._seen.pose if self._seen is not None and now - self._seen.at <= FRESH else None

    # -- following -----------------------------------------------------------------------------------------------------

    def _step(self) -> None:
        """Decide where the robot drives, and drive there."""
        active, now = self._goals.active, self._context.elapsed()
        if active is None:
            return
        goal = active.goal
        if 0.0 < goal.max_duration <= now - self._began:
            self._end(Status.SUCCEEDED, "")
            return
        seen = self._look(goal, now)
        if seen is None:
            self._wait(goal, now)
            return
        self._lost_since = now
        try:
            robot = self._surroundings.pose(now)
        except PPaaSError:
            return  # Move Base stands, and says why
        self._follow(robot, _place_behind(seen, robot))
        self._feed_back(goal, now)

    def _wait(self, goal: ObjectGoal, now: float) -> None:
        """Stand while the object is not seen; give up after some time."""
        self._stop("The object is not seen.")
        if self._phase is not FollowObjectPhase.INITIAL_PERCEPTION:
            self._phase = FollowObjectPhase.RETRY
        if now - self._lost_since > LOST:
            what = f"frame {goal.frame!r}" if goal.frame else f"topic {topics.DYNAMIC_POSE.name!r}"
            text = f"the object was not seen for {LOST:g} s: there are no new transforms or poses of {what}"
            self._end(Status.ABORTED, text, FollowObjectError.FAILED_TO_DETECT_OBJECT)
        else:
            self._feed_back(goal, now)

    def _follow(self, robot: Pose2D, place: Pose2D) -> None:
        apart, turned = robot.distance_to(place), abs(wrap_angle(robot.theta - place.theta))
        if self._driving is None:
            self._phase = FollowObjectPhase.STOPPING
            if apart > NEAR or turned > FACING:
                self._drive(place)
        else:
            aim = self._driving.pose
            self._phase = FollowObjectPhase.CONTROLLING
            if aim.distance_to(place) > MOVED or abs(wrap_angle(aim.theta - place.theta)) > TURNED:
                self._driving = Goal(self._driving.id, place, self._driving.stamp)
                self._robot.move_goal(place)

    def _drive(self, place: Pose2D) -> None:
        self._counter += 1
        stamp = self._context.now()
        self._phase = FollowObjectPhase.CONTROLLING
        self._driving = Goal(f"{PREFIX}{self._counter}-{stamp:.3f}", place, stamp)
        self._robot.drive_to(place, GoalID(Time.of(stamp), self._driving.id))

    def _stop(self, reason: str) -> None:
        driving, self._driving = self._driving, None
        if driving is not None:
            self._robot.end_goal(reason)

    def _feed_back(self, goal: ObjectGoal, now: float) -> None:
        if self._goals.active is None or now - self._fed_back < FEEDBACK_PERIOD:
            return
        self._fed_back = now
        feedback = FollowObjectFeedback(int(self._phase), Duration.of(now - self._began), self._retries)
        self._publisher.feedback(goal, feedback)

    # -- ends and checkpoints ------------------------------------------------------------------------------------------

    def _end(self, status: Status, text: str, code: FollowObjectError = FollowObjectError.NONE) -> None:
        """End the goal, if there is one."""
        if self._goals.active is None or self._timer is None:
            return
        self._timer.stop()
        now = self._context.elapsed()
        goal = msgspec.structs.replace(self._goals.end(now, status, text).goal, seconds=now - self._began)
        self._stop(text or "The object is no longer followed.")
        self._publish_end(goal, status, text, code)

    def _publish_end(self, goal: ObjectGoal, status: Status, text: str, code: FollowObjectError) -> None:
        said = text if code else ""
        result = FollowObjectResult(Duration.of(goal.seconds), int(code), self._retries, said)
        self._publisher.result(goal, status, text, result)
        self._publisher.status(self._goals)

    def checkpoint(self) -> ObjectGoal | None:
        """Return the object that is followed; None if there is none."""
        active = self._goals.active
        if active is None:
            return None
        return msgspec.structs.replace(active.goal, seconds=self._context.elapsed() - self._began)

    def restore(self, goal: ObjectGoal | None) -> None:
        """Follow an object on."""
        if goal is not None and not self._goals.knows(goal.id, self._context.elapsed()):
            self._begin(goal)


def _frame_of(goal: FollowObjectGoal) -> str:
    """Return the frame of an object, empty if its poses come by the topic."""
    topic = goal.pose_topic.lstrip("/")
    if topic not in ("", topics.DYNAMIC_POSE.name):
        raise InvalidInput(
            f"poses of objects are taken from {topics.DYNAMIC_POSE.name!r}, not from {topic[:64]!r}: "
            "publish them there, or name a tracked_frame"
        )
    if not topic and not goal.tracked_frame.strip("/"):
        raise InvalidInput(f"name a tracked_frame, or the pose_topic {topics.DYNAMIC_POSE.name!r}")
    return "" if topic else goal.tracked_frame.lstrip("/")


def _limit_of(goal: FollowObjectGoal) -> float:
    seconds = goal.max_duration.seconds()
    if not seconds >= 0.0:  # nor NaN
        raise InvalidInput(f"max_duration must be 0 for no limit, or a time, not {seconds:g} s")
    return seconds


def _place_behind(seen: Pose2D, robot: Pose2D) -> Pose2D:
    """Return the place at the distance from an object at which the robot follows it, and faces it.

    A robot that is nearer stays where it is, and turns to the object.
    """
    apart = robot.distance_to(seen)
    if apart < 1e-6:
        return robot
    heading = math.atan2(seen.y - robot.y, seen.x - robot.x)
    ahead = max(apart - DISTANCE, 0.0)
    return Pose2D(robot.x + ahead * math.cos(heading), robot.y + ahead * math.sin(heading), heading)
