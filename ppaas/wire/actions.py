"""Adapters from rosbridge's actions (ROS 2) to the topics of actionlib (ROS 1), their types and cancel service.

In ROS 1 an action ``A`` consists of the topics ``A/goal``, ``A/cancel``, ``A/status``, ``A/feedback`` and ``A/result``.
``send_action_goal`` reaches each action that has all five, under its own name and with its own fields. In addition,
``navigate_to_pose`` offers ``move_base`` under Nav2's name and with Nav2's fields; `ALIASES` has names alone.

Sources: ``actionlib_msgs/GoalStatus``, ``action_msgs/GoalStatus``, ``nav2_msgs/action/NavigateToPose``.

In ROS 2 an action has one type, ``package/action/Name``. In ROS 1 each of its topics has one,
``package/NameActionGoal`` and so on, whose field ``goal``, ``result`` or ``feedback`` is what is meant here.

Source of the cancel service: ``action_msgs/srv/CancelGoal``. Goals of clients have no UUIDs, so only all goals, or
those up to a stamp, can be cancelled.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Literal

import msgspec
from msgspec import field

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, NotFound, UnknownType
from ppaas.messages import decode, message_type, message_types
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Duration, Time
from ppaas.messages.geometry_msgs import PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseFeedback
from ppaas.messages.nav2_msgs import NavigateToPoseFeedback, NavigateToPoseGoal, NavigateToPoseResult
from ppaas.wire.arguments import as_object
from ppaas.wire.names import is_ros2_type, ros1_type, ros2_type

_encoder = msgspec.json.Encoder()

# -- adapters from rosbridge's actions (ROS 2) to the topics of actionlib (ROS 1) --------------------------------------

NAVIGATE_TO_POSE = "navigate_to_pose"
MOVE_BASE = "move_base"

UNKNOWN, SUCCEEDED, CANCELED, ABORTED = 0, 4, 5, 6
"""Final statuses of ``action_msgs/GoalStatus``; ``UNKNOWN`` is for goals that were refused or lost."""

NAV2_UNKNOWN = 9000
"""``error_code`` of NavigateToPose for all failures of Move Base."""

ALIASES = {"follow_path": "controller_server/follow_path"}
"""Names under which actions of other topics are known: ``follow_path/goal`` belongs to robots that follow paths."""

PARTS = ("goal", "cancel", "status", "feedback", "result")
"""Names of an action's topics, below the name of the action."""

_ENDS = {
    Status.SUCCEEDED: SUCCEEDED,
    Status.PREEMPTED: CANCELED,
    Status.RECALLED: CANCELED,
    Status.ABORTED: ABORTED,
    Status.REJECTED: ABORTED,
}


def ros2_status(status: Status) -> int:
    """Return the final status in ROS 2 of a goal's status in ROS 1."""
    return _ENDS.get(status, UNKNOWN)


@dataclass(frozen=True, slots=True)
class SentGoal:
    """Goal that was sent to an action: its JSON, and when it was sent (monotonic) [s]."""

    goal: bytes
    at: float


class ActionAdapter(ABC):
    """Adapter between one client's view of an action and the action's topics.

    Parameters
    ----------
    topics : str
        Name of the action that has the topics.
    ros2 : bool
        Whether the client expects times spelled as in ROS 2.

    Attributes
    ----------
    progress_topic : str
        Topic of messages for `learn`; empty if there is none.
    """

    progress_topic: ClassVar[str] = ""

    def __init__(self, topics: str, *, ros2: bool) -> None:
        self.topics = topics
        self.ros2 = ros2

    @abstractmethod
    def goal(self, arguments: bytes) -> bytes:
        """Return the JSON of the field ``goal`` in a message for ``A/goal``.

        Raises
        ------
        InvalidInput
            The arguments are not a goal of this action.
        """

    @abstractmethod
    def feedback(self, sent: SentGoal, feedback: bytes, now: float) -> bytes:
        """Return the ``values`` of an ``action_feedback``."""

    def learn(self, progress: bytes) -> None:
        """Take the feedback of a message of ``progress_topic`` about the goal; later feedback has its content."""

    @abstractmethod
    def result(self, result: bytes, status: Status, text: str) -> bytes:
        """Return the ``values`` of an ``action_result``."""


class PlainAction(ActionAdapter):
    """Action under its own name and with its own fields."""

    def __init__(self, topics: str, kind: type[Message] | None, *, ros2: bool) -> None:
        super().__init__(topics, ros2=ros2)
        self._kind = kind

    def goal(self, arguments: bytes) -> bytes:
        """Return the arguments as an object; a list is taken in the order of the goal's fields."""
        return as_object(arguments, self._kind)

    def feedback(self, sent: SentGoal, feedback: bytes, now: float) -> bytes:
        """Return the feedback unchanged."""
        return feedback

    def result(self, result: bytes, status: Status, text: str) -> bytes:
        """Return the result unchanged."""
        return result


class NavigateToPose(ActionAdapter):
    """Nav2's action, executed by Move Base, for one goal.

    What is not in Move Base's feedback comes from its topic ``navigate_to_pose/feedback``: the distance along the path,
    the estimated time, the recoveries and the tracking errors. Until the first such message the distance is the length
    of the straight line.
    """

    progress_topic: ClassVar[str] = f"{NAVIGATE_TO_POSE}/feedback"

    def __init__(self) -> None:
        super().__init__(MOVE_BASE, ros2=True)
        self._progress: NavigateToPoseFeedback | None = None

    def goal(self, arguments: bytes) -> bytes:
        """Return Move Base's goal.

        Raises
        ------
        InvalidInput
            The arguments are not a goal of NavigateToPose, or name a behavior tree.
        """
        requested = decode(NavigateToPoseGoal, as_object(arguments, NavigateToPoseGoal))
        if requested.behavior_tree:
            raise InvalidInput("behavior trees are not supported: leave behavior_tree empty")
        return _encoder.encode({"target_pose": requested.pose})

    def learn(self, progress: bytes) -> None:
        """Take the newest progress of the goal."""
        self._progress = decode(NavigateToPoseFeedback, progress)

    def feedback(self, sent: SentGoal, feedback: bytes, now: float) -> bytes:
        """Return pose, navigation time, and remaining time and distance; the distance is null if unknown."""
        current, known = decode(MoveBaseFeedback, feedback).base_position, self._progress
        return _encoder.encode(
            NavigateToPoseFeedback(
                current,
                Duration.of(max(now - sent.at, 0.0)),
                known.estimated_time_remaining if known else Duration(),
                known.number_of_recoveries if known else 0,
                known.distance_remaining if known else _straight(current, sent.goal),
                known.position_tracking_error if known else 0.0,
                known.heading_tracking_error if known else 0.0,
            )
        )

    def result(self, result: bytes, status: Status, text: str) -> bytes:
        """Return Nav2's error code and a text; 0 and empty if the goal succeeded."""
        if status is Status.SUCCEEDED:
            return _encoder.encode(NavigateToPoseResult(0, ""))
        return _encoder.encode(NavigateToPoseResult(NAV2_UNKNOWN, text))


def _straight(current: PoseStamped, sent: bytes) -> float:
    """Return the distance from a pose to a goal of Move Base [m], NaN if their frames differ."""
    target = decode(_MoveBaseGoal, sent).target_pose
    here, goal = current.pose.position, target.pose.position
    same_frame = current.header.frame_id == target.header.frame_id.removeprefix("/")
    return math.dist((here.x, here.y), (goal.x, goal.y)) if same_frame else math.nan


class _MoveBaseGoal(Message):
    target_pose: PoseStamped


def find_action(name: str, action_type: str, topics: Mapping[str, str]) -> ActionAdapter:
    """Return the adapter for an action that a client named.

    Parameters
    ----------
    name : str
        Name of the action, without a leading slash.
    action_type : str
        Type of the action, spelled as in ROS 1 (``move_base_msgs/MoveBaseAction``) or ROS 2
        (``nav2_msgs/action/NavigateToPose``).
    topics : mapping of str to str
        All topics, and their types as spelled in ROS 1.

    Raises
    ------
    NotFound
        No action has that name; the text lists the actions.
    InvalidInput
        The action has another type.
    UnknownType
        ``action_type`` is not the name of a ROS type.
    """
    wanted = ros1_type(action_type).partition("/")[2].removesuffix("Action")
    below = topics_of(name, topics)
    if below == MOVE_BASE != name:
        _check_type(name, wanted, "NavigateToPose")
        return NavigateToPose()
    base = topics[f"{below}/goal"].removesuffix("ActionGoal")
    _check_type(name, wanted, base.partition("/")[2])
    return PlainAction(below, _goal_fields(f"{base}Goal"), ros2=is_ros2_type(action_type))


def topics_of(name: str, topics: Mapping[str, str]) -> str:
    """Return the name under which an action has its topics.

    Raises
    ------
    NotFound
        No action has that name; the text lists the actions.
    """
    if name == NAVIGATE_TO_POSE and _is_action(MOVE_BASE, topics):
        return MOVE_BASE
    if _is_action(ALIASES.get(name, ""), topics):
        return ALIASES[name]
    if not _is_action(name, topics):
        raise NotFound("action", name, actions(topics))
    return name


def actions(topics: Mapping[str, str]) -> list[str]:
    """Return the sorted names of all actions among the topics."""
    named = (topic.removesuffix("/goal") for topic in topics if topic.endswith("/goal"))
    short = {below: name for name, below in ALIASES.items()}
    found = [short.get(name, name) for name in named if _is_action(name, topics)]
    return sorted([*found, NAVIGATE_TO_POSE] if MOVE_BASE in found else found)


def _is_action(name: str, topics: Mapping[str, str]) -> bool:
    return topics.get(f"{name}/goal", "").endswith("ActionGoal") and all(f"{name}/{part}" in topics for part in PARTS)


def _check_type(name: str, wanted: str, has: str) -> None:
    # Only type names are compared, since packages differ between ROS 1 and ROS 2
    # (tf2_web_republisher, tf2_web_republisher_interfaces).
    if wanted != has:
        raise InvalidInput(f"action {name!r} has type {has}, not {wanted}")


def _goal_fields(name: str) -> type[Message] | None:
    try:
        return message_type(name)
    except InvalidInput:
        return None  # goals of an unknown type must be objects, since the order of fields is not known


# -- types of actions, and of their goals, results and feedback --------------------------------------------------------

Part = Literal["Goal", "Result", "Feedback"]

NAVIGATE_TO_POSE_TYPE = "nav2_msgs/NavigateToPose"
"""Type of the action that has no separate topics."""


def type_of_action(name: str, topics: Mapping[str, str]) -> str:
    """Return the type of an action as spelled in ROS 2; empty if there is none of this name.

    Parameters
    ----------
    name : str
        Name of the action, without a leading slash.
    topics : mapping of str to str
        All topics, and their types as spelled in ROS 1.
    """
    if name not in actions(topics):
        return ""
    below = topics_of(name, topics)
    own = not below == MOVE_BASE != name
    return ros2_type(topics[f"{below}/goal"].removesuffix("ActionGoal") if own else NAVIGATE_TO_POSE_TYPE, "action")


def known_actions() -> list[str]:
    """Return the types of all actions whose definition is known, as spelled in ROS 2."""
    named = {name.removesuffix("ActionGoal") for name in message_types() if name.endswith("ActionGoal")}
    return sorted(ros2_type(name, "action") for name in named | {NAVIGATE_TO_POSE_TYPE})


def part_of_action(name: str, part: Part) -> type[Message]:
    """Return the type of the goals, results or feedback of a type of actions.

    Raises
    ------
    UnknownType
        The type is unknown, or not a type name.
    """
    base = ros1_type(name).removesuffix("Action")
    try:
        return message_type(f"{base}{part}")
    except UnknownType:
        pass
    try:
        on_topic = message_type(f"{base}Action{part}")
    except UnknownType as error:
        raise UnknownType(f"unknown action type {name[:64]!r}; known: {', '.join(known_actions())}") from error
    [kind] = [field.type for field in msgspec.structs.fields(on_topic) if field.name == part.lower()]
    assert isinstance(kind, type) and issubclass(kind, Message)
    return kind


# -- cancel service of a ROS 2 action, as a message for the topic ``cancel`` of a ROS 1 action -------------------------

CANCEL_GOAL = "/_action/cancel_goal"
"""Suffix of the service's name; ``roslib`` calls it without arguments to cancel all goals."""

UNKNOWN_GOAL_ID = 2
"""``return_code`` of ``action_msgs/srv/CancelGoal``: no goal has this id."""


class _Uuid(Message):
    uuid: bytes = bytes(16)


class _GoalInfo(Message):
    goal_id: _Uuid = field(default_factory=_Uuid)
    stamp: Time = field(default_factory=Time)


class _CancelGoalRequest(Message):
    goal_info: _GoalInfo = field(default_factory=_GoalInfo)


class _UpTo(msgspec.Struct):
    stamp: Time


def cancel_message(arguments: bytes) -> bytes | None:
    """Return the message that cancels the requested goals; None if a single goal is requested, by its UUID.

    Raises
    ------
    MalformedMessage
        The arguments are not a request of this service.
    """
    goal = decode(_CancelGoalRequest, as_object(arguments, _CancelGoalRequest)).goal_info
    return None if any(goal.goal_id.uuid) else _encoder.encode(_UpTo(goal.stamp))


def cancelled_until(message: bytes) -> float:
    """Return the time until which goals are cancelled by a message of ``cancel_message`` [s]; without a stamp, all."""
    stamp = from_json(message, _UpTo).stamp
    return stamp.seconds() or math.inf


def cancel_response(return_code: int) -> bytes:
    """Return the response of the service."""
    return b'{"return_code":%d,"goals_canceling":[]}' % return_code
