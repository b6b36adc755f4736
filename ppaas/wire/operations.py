"""What a client of rosbridge says, as types: one frame, one operation.

Source of the facts: ``RobotWebTools/rosbridge_suite``, ``ROSBRIDGE_PROTOCOL.md``. What a message, a request or a goal
carries is not looked at here: it stays the JSON that the client sent.
"""

from typing import Literal

import msgspec

Level = Literal["none", "error", "warning", "info"]
LEVELS: tuple[Level, ...] = ("none", "error", "warning", "info")
"""From the fewest reports to the most."""

_EMPTY = msgspec.Raw(b"{}")


class Operation(msgspec.Struct, tag_field="op"):
    """One frame of a client."""


# -- topics ------------------------------------------------------------------------------------------------------------


class Publish(Operation, tag="publish"):
    """A message for a topic."""

    topic: str
    msg: msgspec.Raw
    id: str | None = None
    latch: bool = False


class Advertise(Operation, tag="advertise"):
    """The client will publish on a topic; ``latch``: whoever subscribes later gets the last message."""

    topic: str
    type: str
    id: str | None = None
    latch: bool = False
    queue_size: int = 100


class Unadvertise(Operation, tag="unadvertise"):
    """The client will publish no more on a topic: by the advertisement of that id, or by all of this client's."""

    topic: str
    id: str | None = None


class Subscribe(Operation, tag="subscribe"):
    """Hear a topic: at most once in ``throttle_rate`` ms, with ``queue_length`` messages kept that must wait."""

    topic: str
    id: str | None = None
    type: str | None = None
    throttle_rate: float = 0
    queue_length: int = 0
    fragment_size: int | None = None
    compression: str = "none"


class Unsubscribe(Operation, tag="unsubscribe"):
    """Hear a topic no more: the subscription of that id, or all of this client's."""

    topic: str
    id: str | None = None


# -- services ----------------------------------------------------------------------------------------------------------


class CallService(Operation, tag="call_service"):
    """Call a service; the arguments are the object of its request, or a list in the order of the request's fields."""

    service: str
    id: str | None = None
    args: msgspec.Raw = _EMPTY
    type: str | None = None
    timeout: float | None = None


class AdvertiseService(Operation, tag="advertise_service"):
    """The client answers calls of a service."""

    service: str
    type: str


class UnadvertiseService(Operation, tag="unadvertise_service"):
    """The client answers calls of a service no more."""

    service: str


class ServiceResponse(Operation, tag="service_response"):
    """What the client answers to a call; where ``result`` is not true, ``values`` may be the reason as text."""

    service: str
    result: bool | None = None
    values: msgspec.Raw = _EMPTY
    id: str | None = None


# -- actions -----------------------------------------------------------------------------------------------------------


class SendActionGoal(Operation, tag="send_action_goal"):
    """Send a goal to an action; ``feedback``: tell how it comes along."""

    action: str
    action_type: str
    id: str | None = None
    args: msgspec.Raw = _EMPTY
    feedback: bool = False


class CancelActionGoal(Operation, tag="cancel_action_goal"):
    """Cancel the goal of that id."""

    action: str
    id: str | None = None


# -- the session itself ------------------------------------------------------------------------------------------------


class SetLevel(Operation, tag="set_level"):
    """Tell the client of what is this bad or worse, by ``status``."""

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
