"""Records as bytes.

The format is MessagePack with field names, so a new field with a default can be read from older records.
"""

import logging
from collections.abc import Iterable
from typing import TypeVar

import msgspec

from ppaas.errors import InvalidInput, Unavailable

logger = logging.getLogger(__name__)

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


def decode_readable(rows: Iterable[bytes], kind: type[R], limit: int | None = None) -> list[R]:
    """Return the records that can be read, at most ``limit``; damaged ones are left out and logged."""
    found: list[R] = []
    for data in rows:
        if limit is not None and len(found) >= limit:
            break
        try:
            found.append(decode(data, kind))
        except Unavailable as error:
            logger.error("a record is left out of a list: %s", error)
    return found
