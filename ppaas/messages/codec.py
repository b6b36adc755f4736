"""Messages to JSON and back."""

from functools import cache
from typing import TypeVar, cast

import msgspec

from ppaas.errors import MalformedMessage
from ppaas.messages.message import Message

M = TypeVar("M", bound=Message)

_encoder = msgspec.json.Encoder()


@cache
def _decoder(cls: type[Message]) -> msgspec.json.Decoder[Message]:
    return msgspec.json.Decoder(cls)


def encode(message: Message) -> bytes:
    """Return the message as JSON; NaN and infinity become null."""
    return _encoder.encode(message)


def decode(cls: type[M], data: bytes | str | msgspec.Raw) -> M:
    """Read one message of a known type.

    Raises
    ------
    MalformedMessage
        Not JSON, or not of that type; the text says where.
    """
    try:
        return cast(M, _decoder(cls).decode(data))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MalformedMessage(f"not a {cls.__name__}: {error}") from error
