"""Messages in CBOR for subscriptions with ``compression: cbor``, as ``rosbridge_suite`` sends them.

Lists of numbers become typed arrays (RFC 8746) in little-endian order, ``uint8[]`` becomes a byte string, all else is
CBOR of the same name. Types decide that: messages of types that the cloud does not know have plain lists.

Source: ``rosbridge_library/internal/cbor_conversion.py`` of ``RobotWebTools/rosbridge_suite``.
"""

import base64
import binascii
from collections.abc import Callable, Mapping
from functools import cache, lru_cache
from typing import Any, Final

import msgspec
import numpy as np
from msgspec import inspect

from ppaas.errors import UnknownType
from ppaas.messages import message_type
from ppaas.messages.base.message import Message, message_of, plain, struct_of
from ppaas.messages.codec import OTHER_SPELLINGS
from ppaas.wire.binary.binary_frame import BinaryFrame

_ARRAYS: Final[Mapping[str, tuple[int, str]]] = {
    "uint16": (69, "<u2"), "uint32": (70, "<u4"), "uint64": (71, "<u8"),
    "int8": (72, "i1"), "int16": (77, "<i2"), "int32": (78, "<i4"), "int64": (79, "<i8"),
    "float32": (85, "<f4"), "float64": (86, "<f8"),
}  # fmt: skip
"""Tag and type of numbers by the ROS type of the elements."""

_HEAD: Final = b"\xa3\x62op\x67publish\x65topic"
"""Begin of a map of three members, the first of which is the operation, and the key of the second."""

_MESSAGE: Final = b"\x63msg"
"""Key of the third member."""

_Convert = Callable[[Any], object]
"""Called with a value of JSON; returns what is encoded for it."""


def cbor_frame(spelling: str, message: bytes, kind: str | None) -> BinaryFrame:
    """Return the frame that publishes a message in CBOR.

    Parameters
    ----------
    spelling : str
        Name of the topic as the client spells it.
    message : bytes
        The message as JSON, spelled as the client expects.
    kind : str, optional
        Type of the topic.
    """
    import cbor2  # noqa: PLC0415  # needed only for clients of CBOR

    return BinaryFrame(_HEAD + cbor2.dumps(spelling) + _MESSAGE + _content(message, kind))


@lru_cache(maxsize=1)
def _content(message: bytes, kind: str | None) -> bytes:
    """Return a message in CBOR; all subscribers of its topic share it, as they are sent it one after the other."""
    import cbor2  # noqa: PLC0415

    return cbor2.dumps(_converter(kind)(msgspec.json.decode(message)))


def _converter(kind: str | None) -> _Convert:
    try:
        return _message_converter(message_type(kind)) if kind is not None else _unchanged
    except UnknownType:
        return _unchanged


def _unchanged(value: object) -> object:
    return value


@cache
def _message_converter(cls: type[Message]) -> _Convert:
    fields = {field.encode_name: convert for field in struct_of(cls).fields if (convert := _converter_of(field.type))}
    fields |= {other: fields[name] for other, name in OTHER_SPELLINGS.get(cls, {}).items() if name in fields}
    if not fields:
        return _unchanged

    def convert_message(value: Any) -> object:
        if not isinstance(value, dict):
            return value
        return {name: fields.get(name, _unchanged)(member) for name, member in value.items()}

    return convert_message


def _converter_of(kind: inspect.Type) -> _Convert | None:
    """Return the converter of a field, or None if it stays as it is in JSON."""
    kind, _, _ = plain(kind)
    if isinstance(kind, inspect.BytesType):
        return _bytes
    if isinstance(kind, inspect.ListType):
        return _list_converter(kind.item_type)
    message = message_of(kind)
    if message is None:
        return None
    convert = _message_converter(message)
    return convert if convert is not _unchanged else None


def _list_converter(item: inspect.Type) -> _Convert | None:
    kind, _, ros = plain(item)
    ros = ros or {inspect.FloatType: "float64", inspect.IntType: "int32"}.get(type(kind), "")
    if ros in _ARRAYS:
        return _array_converter(*_ARRAYS[ros])
    convert = _converter_of(item)
    if convert is None:
        return None
    return lambda values: [convert(value) for value in values] if isinstance(values, list) else values


def _array_converter(tag: int, kind: str) -> _Convert:
    from cbor2 import CBORTag  # noqa: PLC0415

    def convert_list(values: Any) -> object:
        try:
            numbers = np.array(values, dtype=kind)  # null becomes NaN in floats
        except (TypeError, ValueError, OverflowError):
            return values  # a message of a client that is not of this type
        return CBORTag(tag, numbers.tobytes()) if isinstance(values, list) and numbers.ndim == 1 else values

    return convert_list


def _bytes(value: Any) -> object:
    try:
        return base64.b64decode(value, validate=True) if isinstance(value, str) else bytes(value)
    except (binascii.Error, TypeError, ValueError):
        return value
