"""Completion of what passes from client to client: checked by its type, with defaults for what is left out.

That are messages on topics, requests and responses of services, and goals, feedback and results of actions. A header
that names no time is stamped. Source: ``ROSBRIDGE_PROTOCOL.md`` (3.3.3) and ``message_conversion.py`` of
``RobotWebTools/rosbridge_suite``.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, get_args

import msgspec

from ppaas.clock import Clock, epoch
from ppaas.errors import UnknownType
from ppaas.messages.base.message import Message, struct_of
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.codec import decode, encode
from ppaas.messages.registry import message_type, service_type
from ppaas.wire.actions import Part, part_of_action
from ppaas.wire.arguments import as_object

Complete = Callable[[bytes], bytes]
"""Called with a message as JSON; returns it with all fields of its type, or raises ``MalformedMessage``."""


class _Stamped(msgspec.Struct):
    header: Any = None


_stamped = msgspec.json.Decoder(_Stamped)


def completion_of(kind: str, now: Clock = epoch) -> Complete | None:
    """Return what completes messages of a type, given by its name in ROS 1; None if they pass as they are.

    That are messages of types that the cloud does not know, and of its own types, of which releases know other fields.

    Parameters
    ----------
    kind : str
    now : callable
        Returns the time since the epoch [s].
    """
    try:
        cls = message_type(kind)
    except UnknownType:
        return None
    return _completion_by(cls, now)


class ServiceCompletion(NamedTuple):
    """What completes requests and responses of a type of services; None if they pass as they are."""

    request: Complete | None = None
    response: Complete | None = None


def service_completion(kind: str) -> ServiceCompletion:
    """Return what completes requests and responses of a type of services, given by its name in ROS 1."""
    try:
        service = service_type(kind)
    except UnknownType:
        return ServiceCompletion()
    return ServiceCompletion(_completion_by(service.request), _of_object(service.response))


class ActionCompletion(NamedTuple):
    """What completes goals, feedback and results of a type of actions; None if they pass as they are."""

    goal: Complete | None = None
    feedback: Complete | None = None
    result: Complete | None = None


def action_completion(kind: str) -> ActionCompletion:
    """Return what completes goals, feedback and results of a type of actions, ``package/Name``."""
    try:
        parts = [part_of_action(kind, part) for part in get_args(Part)]
    except UnknownType:
        return ActionCompletion()
    goal, result, feedback = map(_completion_by, parts)
    return ActionCompletion(goal, feedback, result)


def _of_object(cls: type[Message]) -> Complete | None:
    """Return the completion of messages that may be null or a list of their fields, as responses."""
    complete = _completion_by(cls)
    return None if complete is None else lambda payload: complete(as_object(payload, cls))


def _completion_by(cls: type[Message], now: Clock = epoch) -> Complete | None:
    if not struct_of(cls).forbid_unknown_fields:
        return None

    def complete(payload: bytes) -> bytes:
        message = decode(cls, payload)
        header = getattr(message, "header", None)
        if isinstance(header, Header) and header.stamp == _NEVER and not _names_time(payload):
            header.stamp = Time.of(now())
        return encode(message)

    return complete


_NEVER = Time()


def _names_time(payload: bytes) -> bool:
    """Return whether a message has the time zero in its header, and not just none."""
    try:
        header = _stamped.decode(payload).header
    except msgspec.DecodeError:  # spelled as the standard does not allow: with NaN, for example
        return False
    return isinstance(header, dict) and isinstance(header.get("stamp"), dict)
