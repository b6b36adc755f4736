"""Poses with covariance in CDR, which come with each scan: packed at once instead of field by field."""

import struct
from typing import Final

from ppaas.errors import MalformedMessage
from ppaas.messages import decode
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.wire.foxglove.conversion.base import Conversion
from ppaas.wire.foxglove.conversion.frames import SharedFrames
from ppaas.wire.foxglove.conversion.schemas import cdr

KIND: Final = "geometry_msgs/PoseWithCovarianceStamped"

_HEAD: Final = struct.Struct("<4siII")
_NUMBERS: Final = struct.Struct("<43d")
_LITTLE_ENDIAN: Final = b"\0\1\0\0"


def _convert(payload: bytes, frames: SharedFrames) -> bytes:
    message = decode(PoseWithCovarianceStamped, payload)
    stamp, frame = message.header.stamp, frames.shared(message.header.frame_id).encode() + b"\0"
    at, q = message.pose.pose.position, message.pose.pose.orientation
    try:
        head = _HEAD.pack(_LITTLE_ENDIAN, stamp.secs, stamp.nsecs, len(frame))
        numbers = _NUMBERS.pack(at.x, at.y, at.z, q.x, q.y, q.z, q.w, *message.pose.covariance)
    except struct.error as error:
        raise MalformedMessage(f"not a {KIND}: {error}") from error
    aligned = -(len(head) - len(_LITTLE_ENDIAN) + len(frame)) % 8
    return head + frame + bytes(aligned) + numbers


def located() -> Conversion:
    """Return the conversion of ``geometry_msgs/PoseWithCovarianceStamped``."""
    return Conversion(cdr(KIND), _convert)
