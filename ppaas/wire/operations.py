"""Operations that rosbridge clients send, one struct per ``op``.

Source: ``ROSBRIDGE_PROTOCOL.md`` of ``RobotWebTools/rosbridge_suite``. Messages, requests and goals are not decoded
here; they stay the client's JSON.
"""

from typing import Literal

import msgspec

Level = Literal["none", "error", "warning", "info"]
LEVELS: tuple[Level, ...] = ("none", "error", "warning", "info")
"""Status levels, from the fewest reports to the most."""

_EMPTY = msgspec.Raw(b"{}")


class Operation(msgspec.Struct, tag_field="op"):
    """Base of all operations; a frame carries one operation."""


# -- topics ------------------------------------------------------------------------------------------------------------


class Publish(Operation, tag="publish"):
    """Publish a message on a topic."""

    topic: str
    msg: msgspec.Raw
    id: str | None = None
    latch: bool = False


class Advertise(Operation, tag="advertise"):
    """Announce that the client will publish on a topic; with ``latch``, later subscribers get the last message."""

    topic: str
    type: str
    id: str | None = None
    latch: bool = False
    queue_size: int = 100


class Unadvertise(Operation, tag="unadvertise"):
    """Withdraw the advertisement with that id, or all of this client's advertisements of the topic."""

    topic: str
    id: str | None = None


class Subscribe(Operation, tag="subscribe"):
    """Subscribe to a topic: at most one message per ``throttle_rate`` ms, with a queue of ``queue_length`` messages."""

    topic: str
    id: str | None = None
    type: str | None = None
    throttle_rate: float = 0
    queue_length: int = 0
    fragment_size: int | None = None
    compression: str = "none"


class Unsubscribe(Operation, tag="unsubscribe"):
    """End the subscription with that id, or all of this client's subscriptions to the topic."""

    topic: str
    id: str | None = None


# -- services ----------------------------------------------------------------------------------------------------------


class CallService(Operation, tag="call_service"):
    """Call a service; ``args`` is the request as an object, or a list in the order of the request's fields."""

    service: str
    id: str | None = None
    args: msgspec.Raw = _EMPTY
    type: str | None = None
    timeout: float | None = None


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
    id: str | None = None


# -- actions -----------------------------------------------------------------------------------------------------------


class SendActionGoal(Operation, tag="send_action_goal"):
    """Send a goal to an action; with ``feedback``, the client receives the action's feedback."""

    action: str
    action_type: str
    id: str | None = None
    args: msgspec.Raw = _EMPTY
    feedback: bool = False


class CancelActionGoal(Operation, tag="cancel_action_goal"):
    """Cancel the goal with that id."""

    action: str
    id: str | None = None


# -- the session -------------------------------------------------------------------------------------------------------


class SetLevel(Operation, tag="set_level"):
    """Request ``status`` frames of this level and above."""

    level: Level
    id: str | None = None


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
    | SetLevel
)
