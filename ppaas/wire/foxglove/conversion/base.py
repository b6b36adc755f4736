"""Conversion of the messages of one type, and the reading of messages of any type."""

from collections.abc import Callable
from typing import Any, NamedTuple

import msgspec

from ppaas.errors import MalformedMessage
from ppaas.wire.foxglove.answers import Schema
from ppaas.wire.foxglove.conversion.frames import SharedFrames

_decoder = msgspec.json.Decoder()


class Conversion(NamedTuple):
    """Conversion of messages, given as JSON of rosbridge, to the encoding of a schema.

    ``convert`` raises ``MalformedMessage`` if the message is not of its type.
    """

    schema: Schema
    convert: Callable[[bytes, SharedFrames], bytes]


def read_object(kind: str, payload: bytes) -> dict[str, Any]:
    """Return a message given as JSON as a dict; raises ``MalformedMessage`` if it is not an object of JSON."""
    try:
        values = _decoder.decode(payload)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise MalformedMessage(f"not a {kind}: not JSON: {error}") from error
    if not isinstance(values, dict):
        raise MalformedMessage(f"not a {kind}: not an object")
    return values
