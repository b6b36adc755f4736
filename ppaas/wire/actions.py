"""Actions as rosbridge has them (ROS 2), over the topics of which an action is made here (ROS 1).

An action ``A`` of ROS 1 is the topics ``A/goal``, ``A/cancel``, ``A/status``, ``A/feedback`` and ``A/result``
(actionlib). Whatever has them can be reached by ``send_action_goal``, under its own name and with its own fields.
``navigate_to_pose`` is Nav2's name for what ``move_base`` does, with Nav2's fields.

Sources: ``actionlib_msgs/GoalStatus``, ``action_msgs/GoalStatus``, ``nav2_msgs/action/NavigateToPose``.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass

import msgspec

from ppaas.errors import InvalidInput, NotFound
from ppaas.messages import decode, message_type
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.message import Message
from ppaas.messages.move_base_msgs import MoveBaseFeedback
from ppaas.wire.arguments import as_object
from ppaas.wire.names import is_ros2_type, ros1_type

_encoder = msgspec.json.Encoder()

NAVIGATE_TO_POSE = "navigate_to_pose"
MOVE_BASE = "move_base"

UNKNOWN, SUCCEEDED, CANCELED, ABORTED = 0, 4, 5, 6
"""Of ``action_msgs/GoalStatus``, what a goal can end with; unknown is one that was never taken, or was lost."""

NAV2_UNKNOWN = 9000
"""``error_code`` of NavigateToPose for a failure that has no code of its own."""

PARTS = ("goal", "cancel", "status", "feedback", "result")
"""The topics of an action, below its name."""

_ENDS = {
    Status.SUCCEEDED: SUCCEEDED,
    Status.PREEMPTED: CANCELED,
    Status.RECALLED: CANCELED,
    Status.ABORTED: ABORTED,
    Status.REJECTED: ABORTED,
}


def ros2_status(status: Status) -> int:
    """Return how a goal of ROS 1 ended, as ROS 2 counts it."""
    return _ENDS.get(status, UNKNOWN)


@dataclass(frozen=True, slots=True)
class SentGoal:
    """What was asked of an action, and when [s]."""

    goal: bytes
    at: float


class Action(ABC):
    """One action, as one client means it: by the type that it gave.

    Parameters
    ----------
    topics : str
        Name of the action whose topics carry it.
    ros2 : bool
        Times are spelled as in ROS 2.
    """

    def __init__(self, topics: str, *, ros2: bool) -> None:
        self.topics = topics
        self.ros2 = ros2

    @abstractmethod
    def goal(self, arguments: bytes) -> bytes:
        """Return the JSON of ``A/goal``'s field ``goal``.

        Raises
        ------
        InvalidInput
            The arguments cannot be its goal.
        """

    @abstractmethod
    def feedback(self, sent: SentGoal, feedback: bytes, now: float) -> bytes:
        """Return the values of an ``action_feedback``."""

    @abstractmethod
    def result(self, result: bytes, status: Status, text: str) -> bytes:
        """Return the values of an ``action_result``."""


class PlainAction(Action):
    """An action under its own name and with its own fields."""

    def __init__(self, topics: str, kind: type[Message] | None, *, ros2: bool) -> None:
        super().__init__(topics, ros2=ros2)
        self._kind = kind

    def goal(self, arguments: bytes) -> bytes:
        """Return the arguments; a list is in the order of the goal's fields."""
        return as_object(arguments, self._kind)

    def feedback(self, sent: SentGoal, feedback: bytes, now: float) -> bytes:
        """Return the feedback as it is."""
        return feedback

    def result(self, result: bytes, status: Status, text: str) -> bytes:
        """Return the result as it is."""
        return result


class NavigateToPoseGoal(Message):
    """``nav2_msgs/action/NavigateToPose`` goal."""

    pose: PoseStamped
    behavior_tree: str = ""


class _NavigateToPoseFeedback(msgspec.Struct):
    current_pose: PoseStamped
    navigation_time: dict[str, int]
    distance_remaining: float


class _NavigateToPoseResult(msgspec.Struct):
    error_code: int
    error_msg: str


class NavigateToPose(Action):
    """Nav2's action, carried out by Move Base. The remaining distance is that of the straight line."""

    def __init__(self) -> None:
        super().__init__(MOVE_BASE, ros2=True)

    def goal(self, arguments: bytes) -> bytes:
        """Return Move Base's goal.

        Raises
        ------
        InvalidInput
            No such goal, or one with a behaviour tree of its own.
        """
        asked = decode(NavigateToPoseGoal, as_object(arguments, NavigateToPoseGoal))
        if asked.behavior_tree:
            raise InvalidInput("Move Base has no behaviour trees: leave behavior_tree empty")
        return _encoder.encode({"target_pose": asked.pose})

    def feedback(self, sent: SentGoal, feedback: bytes, now: float) -> bytes:
        """Return where the robot is, for how long it has been under way, and how far from the goal."""
        here = decode(MoveBaseFeedback, feedback).base_position
        target = decode(_MoveBaseGoal, sent.goal).target_pose
        away = math.dist((here.pose.position.x, here.pose.position.y), (target.pose.position.x, target.pose.position.y))
        distance = away if here.header.frame_id == target.header.frame_id.removeprefix("/") else math.nan
        whole, part = divmod(max(now - sent.at, 0.0), 1.0)
        took = {"sec": int(whole), "nanosec": int(part * 1e9)}
        return _encoder.encode(_NavigateToPoseFeedback(here, took, distance))

    def result(self, result: bytes, status: Status, text: str) -> bytes:
        """Return Nav2's code of the failure, and why in words; both empty where there was none."""
        if status is Status.SUCCEEDED:
            return _encoder.encode(_NavigateToPoseResult(0, ""))
        return _encoder.encode(_NavigateToPoseResult(NAV2_UNKNOWN, text))


class _MoveBaseGoal(Message):
    target_pose: PoseStamped


def find_action(name: str, action_type: str, topics: Mapping[str, str]) -> Action:
    """Return the action that a client means.

    Parameters
    ----------
    name : str
        Without a leading slash.
    action_type : str
        In the spelling of ROS 1 (``move_base_msgs/MoveBaseAction``) or ROS 2 (``nav2_msgs/action/NavigateToPose``).
    topics : mapping of str to str
        The topics that there are, and their types as ROS 1 spells them.

    Raises
    ------
    NotFound
        There is no such action.
    InvalidInput
        It has another type.
    """
    wanted = ros1_type(action_type).partition("/")[2].removesuffix("Action")
    if name == NAVIGATE_TO_POSE and _is_action(MOVE_BASE, topics):
        _check_type(name, wanted, "NavigateToPose")
        return NavigateToPose()
    if not _is_action(name, topics):
        raise NotFound("action", name, actions(topics))
    base = topics[f"{name}/goal"].removesuffix("ActionGoal")
    _check_type(name, wanted, base.partition("/")[2])
    return PlainAction(name, _goal_fields(f"{base}Goal"), ros2=is_ros2_type(action_type))


def actions(topics: Mapping[str, str]) -> list[str]:
    """Return the names of the actions that there are."""
    named = (topic.removesuffix("/goal") for topic in topics if topic.endswith("/goal"))
    found = [name for name in named if _is_action(name, topics)]
    return sorted([*found, NAVIGATE_TO_POSE] if MOVE_BASE in found else found)


def _is_action(name: str, topics: Mapping[str, str]) -> bool:
    return topics.get(f"{name}/goal", "").endswith("ActionGoal") and all(f"{name}/{part}" in topics for part in PARTS)


def _check_type(name: str, wanted: str, has: str) -> None:
    # Packages differ between ROS 1 and ROS 2 (tf2_web_republisher, tf2_web_republisher_interfaces): the name decides.
    if wanted != has:
        raise InvalidInput(f"action {name!r} is a {has}, not a {wanted}")


def _goal_fields(name: str) -> type[Message] | None:
    try:
        return message_type(name)
    except InvalidInput:
        return None  # then its goals are objects, never lists
