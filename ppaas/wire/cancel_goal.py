"""Cancel service of a ROS 2 action, as a message for the topic ``cancel`` of a ROS 1 action.

Source: ``action_msgs/srv/CancelGoal``. Goals of clients have no UUIDs, so only all goals, or those up to a stamp, can
be cancelled.
"""

import math

import msgspec
from msgspec import field

from ppaas.decoding import from_json
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.codec import decode
from ppaas.wire.arguments import as_object

CANCEL_GOAL = "/_action/cancel_goal"
"""Suffix of the service's name; ``roslib`` calls it without arguments to cancel all goals."""

UNKNOWN_GOAL_ID = 2
"""``return_code`` of ``action_msgs/srv/CancelGoal``: no goal has this id."""

_encoder = msgspec.json.Encoder()


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
