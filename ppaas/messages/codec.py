"""Messages as JSON: encoding and decoding."""

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
    """Decode a message of the given type, whose times may be spelled as in ROS 1 or ROS 2.

    Raises
    ------
    MalformedMessage
        The data is not JSON, or not of that type; the text names the place in the message.
    """
    decoder = _decoder(cls)
    try:
        try:
            return cast(M, decoder.decode(data))
        except msgspec.ValidationError:
            # `Time` forbids unknown keys, so ROS 2's spelling always gets here, and other messages cost nothing more.
            original = data.encode() if isinstance(data, str) else bytes(data)
            if (respelled := to_ros1(original)) == original:
                raise
            return cast(M, decoder.decode(respelled))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise MalformedMessage(f"not a {cls.__name__}: {error}") from error
