"""Frames about goals of actions, as the cloud sends them to the client that executes a goal or that sent it."""

import msgspec

from ppaas.errors import PPaaSError
from ppaas.wire.operations import Id

_encoder = msgspec.json.Encoder()


class _SendActionGoal(msgspec.Struct, tag_field="op", tag="send_action_goal"):
    id: str
    action: str
    action_type: str
    args: msgspec.Raw
    feedback: bool = True


class _CancelActionGoal(msgspec.Struct, tag_field="op", tag="cancel_action_goal"):
    id: str
    action: str


class _ActionFeedback(msgspec.Struct, tag_field="op", tag="action_feedback"):
    action: str
    values: msgspec.Raw
    id: Id


class _ActionResult(msgspec.Struct, tag_field="op", tag="action_result"):
    action: str
    values: msgspec.Raw | str
    status: int
    result: bool
    id: Id


def goal_frame(action: str, action_type: str, goal: int, arguments: bytes) -> bytes:
    """Return the frame that asks a client to execute a goal; action and type are spelled as the client did."""
    return _encoder.encode(_SendActionGoal(str(goal), action, action_type, msgspec.Raw(arguments)))


def cancel_frame(action: str, goal: int) -> bytes:
    """Return the frame that asks a client to cancel a goal that it executes."""
    return _encoder.encode(_CancelActionGoal(str(goal), action))


def feedback_frame(action: str, goal: Id, values: bytes) -> bytes:
    """Return the frame with feedback for the client that sent a goal."""
    return _encoder.encode(_ActionFeedback(action, msgspec.Raw(values), goal))


def result_frame(action: str, goal: Id, status: int, result: bytes | PPaaSError) -> bytes:
    """Return the frame that ends a goal; the ``values`` of an error are the reason as text."""
    if isinstance(result, PPaaSError):
        return _encoder.encode(_ActionResult(action, result.public, status, False, goal))
    return _encoder.encode(_ActionResult(action, msgspec.Raw(result), status, True, goal))
