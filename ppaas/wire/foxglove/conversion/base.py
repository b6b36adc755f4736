"""Conversion of the messages of one type."""

from collections.abc import Callable
from typing import NamedTuple

from ppaas.wire.foxglove.answers import Schema
from ppaas.wire.foxglove.conversion.frames import SharedFrames


class Conversion(NamedTuple):
    """Conversion of messages, given as JSON of rosbridge, to the encoding of a schema.

    ``convert`` raises ``MalformedMessage`` if the message is not of its type.
    """

    schema: Schema
    convert: Callable[[bytes, SharedFrames], bytes]
