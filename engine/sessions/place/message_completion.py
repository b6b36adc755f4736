"""Completion of messages that pass from client to client: checked by their type, with defaults for what is left out.

A header that names no time is stamped. Source: ``ROSBRIDGE_PROTOCOL.md`` (3.3.3) and ``message_conversion.py`` of
``RobotWebTools/rosbridge_suite``.
"""

from collections.abc import Callable
from typing import Any

import msgspec

from ppaas.clock import Clock, epoch
from ppaas.errors import UnknownType
from ppaas.messages.base.message import struct_of
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.codec import decode, encode
from ppaas.messages.registry import message_type

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
