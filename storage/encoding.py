"""Records as bytes.

MessagePack, so that a field that is added with a default reads from records that were kept before it was there.
"""

from typing import TypeVar

import msgspec

from ppaas.errors import InvalidInput, Unavailable

R = TypeVar("R", bound=msgspec.Struct)


def encode(record: msgspec.Struct) -> bytes:
    """Return a record as bytes.

    Raises
    ------
    InvalidInput
        A free part of it, such as a robot's parameters, holds what cannot be kept.
    """
    try:
        return msgspec.msgpack.encode(record)
    except (TypeError, ValueError, OverflowError, RecursionError) as error:
        raise InvalidInput(f"the {type(record).__name__} cannot be kept: {error}") from error


def decode(data: bytes, kind: type[R]) -> R:
    """Return the record of these bytes.

    Raises
    ------
    Unavailable
        They are damaged, or of a release that kept it otherwise.
    """
    try:
        return msgspec.msgpack.decode(data, type=kind)
    except msgspec.MsgspecError as error:
        raise Unavailable(f"a stored {kind.__name__} cannot be read ({error}): restore it from a backup") from error
