"""Conversion of each type, and the pictures that are made of topics."""

import struct
from functools import cache
from typing import Any, Final, NamedTuple

import msgspec

from ppaas.errors import MalformedMessage
from ppaas.messages import decode
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.wire.foxglove.conversion.base import Conversion, SharedFrames, read_object
from ppaas.wire.foxglove.conversion.scenes import DRAWN, PEOPLE
from ppaas.wire.foxglove.conversion.schemas import cdr, json_schema
from ppaas.wire.ros.own_types import has_type, types_with

_encoder = msgspec.json.Encoder()

_FRAMELESS: Final = b"frame_id"
"""Bytes without which a message names no frame."""

_LOCATED: Final = "geometry_msgs/PoseWithCovarianceStamped"

_HEAD: Final = struct.Struct("<4siII")
_NUMBERS: Final = struct.Struct("<43d")
_LITTLE_ENDIAN: Final = b"\0\1\0\0"


def _in_cdr(kind: str) -> Conversion:
    """Return the conversion of a type of ROS 2 or of the cloud to CDR; it is given as spelled in ROS 1."""
    types = types_with(kind)

    def convert(payload: bytes, frames: SharedFrames) -> bytes:
        return types.encode(kind, _read(kind, payload, frames))

    return Conversion(cdr(kind), convert)


def _in_json(kind: str) -> Conversion:
    """Return the conversion of a type of a client that nobody else knows: only its frames are renamed."""

    def convert(payload: bytes, frames: SharedFrames) -> bytes:
        return payload if _FRAMELESS not in payload else _encoder.encode(_read(kind, payload, frames))

    return Conversion(json_schema(kind, None), convert)


def _located_in_cdr(payload: bytes, frames: SharedFrames) -> bytes:
    """Return a pose with covariance in CDR. Such poses come with each scan: packed at once, not field by field."""
    message = decode(PoseWithCovarianceStamped, payload)
    stamp, frame = message.header.stamp, frames.shared(message.header.frame_id).encode() + b"\0"
    at, q = message.pose.pose.position, message.pose.pose.orientation
    try:
        head = _HEAD.pack(_LITTLE_ENDIAN, stamp.secs, stamp.nsecs, len(frame))
        numbers = _NUMBERS.pack(at.x, at.y, at.z, q.x, q.y, q.z, q.w, *message.pose.covariance)
    except struct.error as error:
        raise MalformedMessage(f"not a {_LOCATED}: {error}") from error
    aligned = -(len(head) - len(_LITTLE_ENDIAN) + len(frame)) % 8
    return head + frame + bytes(aligned) + numbers


def _read(kind: str, payload: bytes, frames: SharedFrames) -> dict[str, Any]:
    values = read_object(kind, payload)
    frames.share_all(values)
    return values


class Picture(NamedTuple):
    """Picture that is made of the messages of a topic, beside the messages themselves.

    ``kind`` is the type of these messages, as spelled in ROS 1, and ``topic`` the topic of the picture.
    """

    kind: str
    topic: str
    conversion: Conversion


PICTURES = {"people": Picture("people_msgs/People", "people/scene", PEOPLE)}
"""Pictures by the topic that they are made of."""


@cache
def conversion_of(kind: str) -> Conversion:
    """Return the conversion of the messages of a type, given as spelled in ROS 1."""
    if kind in DRAWN:
        return DRAWN[kind]
    if kind == _LOCATED:
        return Conversion(cdr(kind), _located_in_cdr)
    return _in_cdr(kind) if has_type(kind) else _in_json(kind)
