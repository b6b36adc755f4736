"""Messages of any type: in CDR where the type is known, else as JSON."""

from typing import Any, Final

import msgspec

from ppaas.wire.foxglove.conversion.base import Conversion, read_object
from ppaas.wire.foxglove.conversion.frames import SharedFrames
from ppaas.wire.foxglove.conversion.schemas import cdr, json_schema
from ppaas.wire.ros.own_types import types_with

_encoder = msgspec.json.Encoder()

FRAMELESS: Final = b"frame_id"
"""Bytes without which a message names no frame."""


def in_cdr(kind: str) -> Conversion:
    """Return the conversion of a type of ROS 2 or of the cloud to CDR; it is given as spelled in ROS 1."""
    types = types_with(kind)

    def convert(payload: bytes, frames: SharedFrames) -> bytes:
        return types.encode(kind, _read(kind, payload, frames))

    return Conversion(cdr(kind), convert)


def in_json(kind: str) -> Conversion:
    """Return the conversion of a type of a client that nobody else knows: only its frames are renamed."""

    def convert(payload: bytes, frames: SharedFrames) -> bytes:
        return payload if FRAMELESS not in payload else _encoder.encode(_read(kind, payload, frames))

    return Conversion(json_schema(kind, None), convert)


def _read(kind: str, payload: bytes, frames: SharedFrames) -> dict[str, Any]:
    values = read_object(kind, payload)
    frames.share_all(values)
    return values
