"""Messages as JSON: encoding and decoding."""

from functools import cache
from typing import TypeVar, cast

import msgspec

from ppaas.errors import MalformedMessage
from ppaas.messages.message import Message
from ppaas.messages.spellings.time_spelling import to_ros1
from ppaas.messages.spellings.tolerant import decode_tolerantly

M = TypeVar("M", bound=Message)

_encoder = msgspec.json.Encoder()


@cache
def _decoder(cls: type[Message]) -> msgspec.json.Decoder[Message]:
    return msgspec.json.Decoder(cls)


def encode(message: Message) -> bytes:
    """Return the message as JSON; NaN and infinity become null."""
    return _encoder.encode(message)


def decode(cls: type[M], data: bytes | str | msgspec.Raw) -> M:
    """Decode a message of the given type, strictly or, if that fails, as tolerantly as rosbridge_suite.

    Raises
    ------
    MalformedMessage
        The data is not JSON, or not of that type; the text names the place in the message.
    """
    try:
        return cast(M, _decoder(cls).decode(data))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        # Messages forbid unknown fields, so other spellings always get here, and other messages cost nothing more.
        return _decode_otherwise(cls, data.encode() if isinstance(data, str) else bytes(data))


def _decode_otherwise(cls: type[M], data: bytes) -> M:
    """Decode a message with the times of ROS 2, which many clients send, or else tolerantly, which takes longer."""
    if (respelled := to_ros1(data)) != data:
        try:
            return cast(M, _decoder(cls).decode(respelled))
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
            pass
    try:
        return decode_tolerantly(cls, data)
    except MalformedMessage as error:
        raise MalformedMessage(f"not a {cls.__name__}: {error}") from error
