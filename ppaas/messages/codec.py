"""Messages to JSON and back."""

from functools import cache
from typing import TypeVar, cast

import msgspec

from ppaas.errors import MalformedMessage
from ppaas.messages.message import Message
from ppaas.messages.time_spelling import to_ros1

M = TypeVar("M", bound=Message)

_encoder = msgspec.json.Encoder()


@cache
def _decoder(cls: type[Message]) -> msgspec.json.Decoder[Message]:
    return msgspec.json.Decoder(cls)


def encode(message: Message) -> bytes:
    """Return the message as JSON; NaN and infinity become null."""
    return _encoder.encode(message)


def decode(cls: type[M], data: bytes | str | msgspec.Raw) -> M:
    """Read one message of a known type, with its times as ROS 1 or ROS 2 spells them.

    Raises
    ------
    MalformedMessage
        Not JSON, or not of that type; the text says where.
    """
    decoder = _decoder(cls)
    try:
        try:
            return cast(M, decoder.decode(data))
        except msgspec.ValidationError:
            # A stamp refuses keys that are not its own. Looking for ROS 2's spelling only then costs others nothing.
            given = data.encode() if isinstance(data, str) else bytes(data)
            if (respelled := to_ros1(given)) == given:
                raise
            return cast(M, decoder.decode(respelled))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MalformedMessage(f"not a {cls.__name__}: {error}") from error
