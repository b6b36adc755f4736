"""``move_base_msgs``: the messages of Move Base's action, one type per topic."""

from typing import ClassVar

from msgspec import field

from ppaas.messages.actionlib_msgs import GoalID, GoalStatus
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import PoseStamped


class MoveBaseGoal(Message):
    """``move_base_msgs/MoveBaseGoal``."""

    target_pose: PoseStamped


class MoveBaseActionGoal(Message):
    """``move_base_msgs/MoveBaseActionGoal``."""

    ros_order: ClassVar[tuple[str, ...]] = ("header", "goal_id", "goal")

    goal: MoveBaseGoal
    goal_id: GoalID = field(default_factory=GoalID)
    header: Header = field(default_factory=Header)


class MoveBaseFeedback(Message):
    """``move_base_msgs/MoveBaseFeedback``."""

    base_position: PoseStamped


class MoveBaseActionFeedback(Message):
    """``move_base_msgs/MoveBaseActionFeedback``."""

    header: Header
    status: GoalStatus
    feedback: MoveBaseFeedback


class MoveBaseActionResult(Message):
    """``move_base_msgs/MoveBaseActionResult``; the result itself is empty, as in ROS."""

    header: Header
    status: GoalStatus
    result: Empty = field(default_factory=Empty)
