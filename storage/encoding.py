"""Records as bytes.

The format is MessagePack with field names, so a new field with a default can be read from older records.
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
        A free-form part of it, such as a robot's parameters, contains a value that MessagePack cannot encode.
    """
    try:
        return msgspec.msgpack.encode(record)
    except (TypeError, ValueError, OverflowError, RecursionError) as error:
        raise InvalidInput(f"cannot store this {type(record).__name__}: {error}") from error


def decode(data: bytes, kind: type[R]) -> R:
    """Return the record that was encoded.

    Raises
    ------
    Unavailable
        The bytes are damaged, or were written by a release with another format.
    """
    try:
        return msgspec.msgpack.decode(data, type=kind)
    except msgspec.MsgspecError as error:
        raise Unavailable(f"a stored {kind.__name__} cannot be read ({error}): restore it from a backup") from error
