"""``actionlib_msgs``: goals and their statuses."""

from enum import IntEnum
from typing import ClassVar

from msgspec import field

from ppaas.messages.base.message import Message, UInt8
from ppaas.messages.base.std_msgs import Header, Time


class Status(IntEnum):
    """Status of a goal, with the numbers of ``actionlib_msgs/GoalStatus``."""

    PENDING = 0
    ACTIVE = 1
    PREEMPTED = 2
    SUCCEEDED = 3
    ABORTED = 4
    REJECTED = 5
    PREEMPTING = 6
    RECALLING = 7
    RECALLED = 8
    LOST = 9

    @property
    def terminal(self) -> bool:
        """Return whether the goal has ended."""
        return self not in (Status.PENDING, Status.ACTIVE, Status.PREEMPTING, Status.RECALLING)


class GoalID(Message):
    """``actionlib_msgs/GoalID``; an empty id in a cancel request means all goals."""

    stamp: Time = field(default_factory=Time)
    id: str = ""


class GoalStatus(Message):
    """``actionlib_msgs/GoalStatus``."""

    constants: ClassVar[type[IntEnum] | None] = Status

    goal_id: GoalID
    status: UInt8
    text: str = ""


class GoalStatusArray(Message):
    """``actionlib_msgs/GoalStatusArray``."""

    header: Header = field(default_factory=Header)
    status_list: list[GoalStatus] = field(default_factory=list)
