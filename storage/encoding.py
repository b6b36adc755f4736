"""Records as bytes.

The format is MessagePack with field names, so a new field with a default can be read from older records. The last two
fields are the release that wrote the record, and a checksum, so that a damaged byte is found even if the record can
still be read. Releases that know neither skip both; records that they wrote are read as they are.
"""

import logging
import zlib
from collections.abc import Iterable
from typing import TypeVar

import msgspec

from ppaas import __version__
from ppaas.decoding import from_msgpack
from ppaas.errors import InvalidInput, Unavailable
from storage.store_errors import damaged, of_another_release

logger = logging.getLogger(__name__)

R = TypeVar("R", bound=msgspec.Struct)

Placed = tuple[bytes, str]
"""A record as bytes, and its place: the table and the key."""

_WRITTEN_BY = msgspec.msgpack.encode("release") + msgspec.msgpack.encode(__version__)
_FIELD = msgspec.msgpack.encode("crc")
_UINT32 = b"\xce"
_TAIL = len(_FIELD) + 5

_FIX, _MOST_FIX, _MAP16 = 0x80, 15, 0xDE
"""Headers of maps in MessagePack: one byte with up to 15 fields, or one byte and a 16-bit number."""


def encode(record: msgspec.Struct) -> bytes:
    """Return a record as bytes, with the release and a checksum.

    Raises
    ------
    InvalidInput
        A free-form part of it, such as a robot's parameters, contains a value that MessagePack cannot encode.
    """
    data = encode_plain(record)
    fields, begin = _header(data)
    fields_of_record = memoryview(data)[begin:]
    checksum = zlib.crc32(_WRITTEN_BY, zlib.crc32(fields_of_record, zlib.crc32(_header_of(fields + 1))))
    return b"".join((_header_of(fields + 2), fields_of_record, _WRITTEN_BY, _FIELD, _UINT32, checksum.to_bytes(4)))


def encode_plain(record: msgspec.Struct) -> bytes:
    """Return a record as bytes without a checksum, for hashes and for data that is found by its content.

    Raises
    ------
    InvalidInput
        As ``encode``.
    """
    try:
        return msgspec.msgpack.encode(record)
    except (TypeError, ValueError, OverflowError, RecursionError) as error:
        raise InvalidInput(f"cannot store this {type(record).__name__}: {error}") from error


def decode(data: bytes, kind: type[R], place: str = "") -> R:
    """Return the record that was encoded.

    Parameters
    ----------
    data : bytes
    kind : type
    place : str
        Table and key of the record, for the error.

    Raises
    ------
    Unavailable
        The bytes are damaged, or were written by another release that has other records.
    """
    place = place or f"a stored {kind.__name__}"
    if not is_intact(data):
        raise damaged(place, "its checksum differs")
    try:
        return from_msgpack(data, kind)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError, InvalidInput) as error:
        if _has_checksum(data):
            raise of_another_release(place, _release_of(data), error) from error
        raise damaged(place, error) from error


def is_as_written(data: bytes) -> bool:
    """Return whether a record has its checksum: if it cannot be decoded, another release wrote it."""
    return _has_checksum(data) and is_intact(data)


def is_intact(data: bytes) -> bool:
    """Return whether a record has its checksum, or none."""
    if not _has_checksum(data):
        return True
    fields, begin = _header(data)
    if fields < 1:
        return False
    plain = zlib.crc32(memoryview(data)[begin:-_TAIL], zlib.crc32(_header_of(fields - 1)))
    return plain == int.from_bytes(data[-4:])


def decode_readable(rows: Iterable[Placed], kind: type[R], limit: int | None = None) -> list[R]:
    """Return the records that can be read, at most ``limit``; damaged ones are left out and logged."""
    found: list[R] = []
    for data, place in rows:
        if limit is not None and len(found) >= limit:
            break
        try:
            found.append(decode(data, kind, place))
        except Unavailable as error:
            logger.error("a record is left out of a list: %s", error)
    return found


def _has_checksum(data: bytes) -> bool:
    return bytes(data[-_TAIL:]).startswith(_FIELD + _UINT32)


def _release_of(data: bytes) -> str:
    """Return the release that wrote a record; empty if it does not say so."""
    try:
        return from_msgpack(data, Written).release
    except msgspec.MsgspecError:
        return ""


class Written(msgspec.Struct, frozen=True):
    """The release that wrote a record, in any format with names of fields."""

    release: str = ""


def _header(data: bytes) -> tuple[int, int]:
    if data[0] == _MAP16:
        return int.from_bytes(data[1:3]), 3
    return data[0] - _FIX, 1


def _header_of(fields: int) -> bytes:
    return bytes((_FIX | fields,)) if fields <= _MOST_FIX else bytes((_MAP16,)) + fields.to_bytes(2)
