"""Operations that rosbridge clients send, one struct per ``op``.

Source: ``ROSBRIDGE_PROTOCOL.md`` of ``RobotWebTools/rosbridge_suite``. Messages, requests and goals are not decoded
here; they stay the client's JSON. An optional field that is null counts as left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import msgspec

from ppaas.errors import PPaaSError

Level = Literal["none", "error", "warning", "info"]
LEVELS: tuple[Level, ...] = ("none", "error", "warning", "info")
"""Status levels, from the fewest reports to the most."""

Id: TypeAlias = str | int | None
"""Id of an interaction, chosen by the client and echoed as it came."""

_EMPTY = msgspec.Raw(b"{}")


class Operation(msgspec.Struct, tag_field="op"):
    """Base of all operations; a frame carries one operation.

    ``traceparent``, where an operation has it, is the trace of the client for which it is sent (W3C Trace Context).
    """


# -- topics ------------------------------------------------------------------------------------------------------------


class Publish(Operation, tag="publish"):
    """Publish a message on a topic."""

    topic: str
    msg: msgspec.Raw = _EMPTY
    id: Id = None
    latch: bool | None = False
    traceparent: str | None = None


class Advertise(Operation, tag="advertise"):
    """Announce that the client will publish on a topic; with ``latch``, later subscribers get the last message."""

    topic: str
    type: str
    id: Id = None
    latch: bool | None = False


class Unadvertise(Operation, tag="unadvertise"):
    """Withdraw the advertisement with that id, or all of this client's advertisements of the topic."""

    topic: str
    id: Id = None


class Subscribe(Operation, tag="subscribe"):
    """Subscribe to a topic: at most one message per ``throttle_rate`` ms, with a queue of ``queue_length`` messages.

    Messages of more than ``fragment_size`` characters come in fragments, unless that is 0. Negative numbers count as 0.
    ``compression`` is one of ``COMPRESSIONS`` of ``ppaas.wire.binary.packing``; anything else is as ``none``.
    """

    topic: str
    id: Id = None
    type: str | None = None
    throttle_rate: float | None = 0
    queue_length: int | None = 0
    fragment_size: float | None = 0
    compression: str | None = None


class Unsubscribe(Operation, tag="unsubscribe"):
    """End the subscription with that id, or all of this client's subscriptions to the topic."""

    topic: str
    id: Id = None


# -- services ----------------------------------------------------------------------------------------------------------


class CallService(Operation, tag="call_service"):
    """Call a service; ``args`` is the request as an object, or a list in the order of the request's fields."""

    service: str
    id: Id = None
    args: msgspec.Raw = _EMPTY
    type: str | None = None
    timeout: float | None = None
    fragment_size: float | None = 0
    traceparent: str | None = None


class AdvertiseService(Operation, tag="advertise_service"):
    """Announce that the client serves a service."""

    service: str
    type: str


class UnadvertiseService(Operation, tag="unadvertise_service"):
    """Announce that the client no longer serves a service."""

    service: str


class ServiceResponse(Operation, tag="service_response"):
    """Response of the client to a call; if ``result`` is not true, ``values`` may be the reason as text."""

    service: str
    result: bool | None = None
    values: msgspec.Raw = _EMPTY
    id: Id = None


# -- actions -----------------------------------------------------------------------------------------------------------


class SendActionGoal(Operation, tag="send_action_goal"):
    """Send a goal to an action; with ``feedback``, the client receives the action's feedback."""

    action: str
    action_type: str
    id: Id = None
    args: msgspec.Raw = _EMPTY
    feedback: bool | None = False
    traceparent: str | None = None


class CancelActionGoal(Operation, tag="cancel_action_goal"):
    """Cancel the goal with that id."""

    action: str
    id: Id = None


class AdvertiseAction(Operation, tag="advertise_action"):
    """Announce that the client executes goals of an action."""

    action: str
    type: str
    id: Id = None


class UnadvertiseAction(Operation, tag="unadvertise_action"):
    """Announce that the client no longer executes goals of an action."""

    action: str
    id: Id = None


class ActionFeedback(Operation, tag="action_feedback"):
    """Feedback of the client on a goal that it executes."""

    action: str
    id: Id = None
    values: msgspec.Raw = _EMPTY


class ActionResult(Operation, tag="action_result"):
    """End of a goal that the client executed; if ``result`` is not true, ``values`` may be the reason as text."""

    action: str
    id: Id = None
    values: msgspec.Raw = _EMPTY
    status: int | None = None
    result: bool | None = None


# -- parts of a frame --------------------------------------------------------------------------------------------------


class Fragment(Operation, tag="fragment"):
    """Part ``num`` of the ``total`` parts of a frame, counted from 0."""

    data: str
    num: int
    total: int
    id: Id = None


# -- the session -------------------------------------------------------------------------------------------------------


class SetLevel(Operation, tag="set_level"):
    """Request ``status`` frames of this level and above."""

    level: Level
    id: Id = None


ClientOperation = (
    Publish
    | Advertise
    | Unadvertise
    | Subscribe
    | Unsubscribe
    | CallService
    | AdvertiseService
    | UnadvertiseService
    | ServiceResponse
    | SendActionGoal
    | CancelActionGoal
    | AdvertiseAction
    | UnadvertiseAction
    | ActionFeedback
    | ActionResult
    | SetLevel
    | Fragment
)

CLIENT_OPERATIONS: tuple[str, ...] = tuple(kind.__struct_config__.tag for kind in get_args(ClientOperation))
"""Names of the operations that clients send."""


@dataclass(frozen=True, slots=True)
class RefusedOperation:
    """Frame that is refused, with as much of it as could be read.

    Parameters
    ----------
    error : PPaaSError
        The reason.
    op : str
        Name of the operation; empty if it is unknown.
    id : str or int, optional
        Id of the operation.
    name : str
        Name of the topic, service or action; empty if it is unknown.
    parts : sequence of str
        Frames of which it consists, if it is several in one.
    """

    error: PPaaSError
    op: str = ""
    id: Id = None
    name: str = ""
    parts: Sequence[str] = ()
