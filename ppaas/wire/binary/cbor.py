"""CBOR of rosbridge: messages as ``cbor`` and ``cbor-raw``, and operations of clients as JSON.

Lists of numbers become typed arrays (RFC 8746) in little-endian order, ``uint8[]`` becomes a byte string, all else is
CBOR of the same name. Types decide that: messages of types that the cloud does not know have plain lists.

``rosbridge_suite`` sends CBOR and takes none. Here a client may send each operation of rosbridge as a binary frame of
CBOR: it is read as the JSON that it stands for. Byte strings become base64, typed arrays of numbers become lists. Only
tags of typed arrays are read: other types have no place in a message, and some of them keep a decoder busy for hours,
or build values that contain themselves.

A frame of ``cbor-raw`` is a publication whose ``msg`` has the time of sending, ``secs`` and ``nsecs``, and the
``bytes`` of the message: as in ROS 1 or, for clients that name their type as in ROS 2, as CDR with its header of four
bytes. Clients cannot publish in it.

Source: ``rosbridge_library/internal/cbor_conversion.py`` and ``capabilities/subscribe.py`` of
``RobotWebTools/rosbridge_suite``.
"""

import base64
import binascii
from collections.abc import Callable, Mapping
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import msgspec
import numpy as np
from msgspec import inspect
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge, UnknownType
from ppaas.messages import message_type
from ppaas.messages.base.message import Message, message_of, plain, struct_of
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.codec import OTHER_SPELLINGS
from ppaas.wire.binary.binary_frame import BinaryFrame

if TYPE_CHECKING:
    from cbor2 import CBORTag


# -- messages with ``compression: cbor`` -------------------------------------------------------------------------------

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


# -- operations of clients in CBOR (RFC 8949), with typed arrays (RFC 8746) --------------------------------------------

SELF_DESCRIBED: Final = b"\xd9\xd9\xf7"
"""Tag 55799, which may precede CBOR to distinguish it from other formats (RFC 8949, section 3.4.6)."""

MAX_ITEMS = 65536
"""Largest number of data items of a frame: byte strings and typed arrays are one each, whatever their size."""

MAX_NUMBERS = 262144
"""Largest number of numbers in the typed arrays of a frame."""

MAX_DEPTH = 64
"""Largest number of arrays and maps within each other."""

_REFUSED_TAGS: Final = (
    0, 1, 2, 3, 4, 5, 25, 28, 29, 30, 35, 36, 37, 52, 54, 100, 256, 258, 260, 261, 1004, 43000, 55799,
)  # fmt: skip
"""Tags that the library would read: dates, big numbers, decimals, shared values, regular expressions, addresses."""

_UINT8_TAGS: Final = (64, 68)
"""Typed arrays of bytes, which are base64 in JSON."""

ARRAY_TYPES: Final[Mapping[int, str]] = {
    65: ">u2", 66: ">u4", 67: ">u8", 69: "<u2", 70: "<u4", 71: "<u8",
    72: "i1", 73: ">i2", 74: ">i4", 75: ">i8", 77: "<i2", 78: "<i4", 79: "<i8",
    80: ">f2", 81: ">f4", 82: ">f8", 84: "<f2", 85: "<f4", 86: "<f8",
}  # fmt: skip
"""Types of numbers by the tags of RFC 8746, section 2.1; numbers of 128 bits are not read."""

_encoder = msgspec.json.Encoder()


def is_cbor(frame: bytes) -> bool:
    """Return whether a binary frame begins as a map in CBOR; no JSON does."""
    return frame[:1] >= b"\xa0" and (frame[0] < 0xC0 or frame.startswith(SELF_DESCRIBED))


def cbor_to_json(frame: bytes) -> bytes:
    """Return a value in CBOR as JSON; NaN and infinity become null.

    Raises
    ------
    MalformedMessage
        It is not CBOR, or has a part that JSON and typed arrays cannot express.
    MessageTooLarge
        It has more than ``MAX_ITEMS`` items or ``MAX_NUMBERS`` numbers.
    """
    import cbor2  # noqa: PLC0415  # needed only for clients of CBOR

    data = frame.removeprefix(SELF_DESCRIBED)
    _check_items(data)
    try:
        value = cbor2.loads(data, semantic_decoders=_NO_DECODERS, max_depth=MAX_DEPTH, strict_hashable_types=True)
        return _encoder.encode(_Reader().read(value))
    except cbor2.CBORDecodeError as error:
        if isinstance(error.__cause__, MalformedMessage):
            raise error.__cause__ from None
        raise MalformedMessage(f"not CBOR: {error}") from error
    except OverflowError as error:
        raise MalformedMessage("an integer in CBOR is beyond the range of 64 bits") from error


# -- size --------------------------------------------------------------------------------------------------------------


def _fixed_size(initial: int) -> int:
    """Return the size of the head of an item by its first byte; 0 for strings, which have content."""
    major, info = initial >> 5, initial & 31
    if major in (2, 3) and info != 31:
        return 0
    return 1 + (1 << info - 24 if 24 <= info <= 27 else 0)


_FIXED_SIZES: Final = tuple(_fixed_size(initial) for initial in range(256))


def _check_items(data: bytes) -> None:
    """Raise if the data has too many items, so that a decoder need not build millions of objects.

    Items of CBOR follow one another whatever their nesting, so their heads suffice.
    """
    at, count, end = 0, 0, len(data)
    while at < end:
        count += 1
        if count > MAX_ITEMS:
            raise MessageTooLarge(
                f"a frame in CBOR has at most {MAX_ITEMS} items: send numbers as typed arrays (RFC 8746)"
            )
        at += _FIXED_SIZES[data[at]] or _string_size(data, at)


def _string_size(data: bytes, at: int) -> int:
    info = data[at] & 31
    if info < 24:
        return 1 + info
    width = 1 << info - 24 if info <= 27 else 0
    return 1 + width + int.from_bytes(data[at + 1 : at + 1 + width])


# -- values ------------------------------------------------------------------------------------------------------------


def _refusal(tag: int) -> Callable[[object, bool], object]:
    def refuse(_value: object, _immutable: bool) -> object:
        raise MalformedMessage(f"tag {tag} of CBOR is not read here: send numbers, texts, bytes and typed arrays")

    return refuse


_NO_DECODERS: Final = {tag: _refusal(tag) for tag in _REFUSED_TAGS}


class _Reader:
    """Reader of the values of one frame, which counts the numbers of their typed arrays."""

    def __init__(self) -> None:
        self._numbers = 0

    def read(self, value: Any) -> object:
        """Return a value of CBOR as a value of JSON."""
        if isinstance(value, dict):
            return {self._key(key): self.read(member) for key, member in value.items()}
        if isinstance(value, list):
            return [self.read(member) for member in value]
        if isinstance(value, bytes):
            return base64.b64encode(value).decode()
        if value is None or isinstance(value, str | int | float):
            return value
        return self._special(value)

    @staticmethod
    def _key(key: object) -> str:
        if not isinstance(key, str):
            raise MalformedMessage(f"a key of CBOR must be a text, as in JSON, not {type(key).__name__}")
        return key

    def _special(self, value: Any) -> object:
        import cbor2  # noqa: PLC0415

        if value is cbor2.undefined:
            return None
        if not isinstance(value, cbor2.CBORTag):
            raise MalformedMessage(f"CBOR has a {type(value).__name__}: send numbers, texts, bytes and typed arrays")
        if value.tag in _UINT8_TAGS and isinstance(value.value, bytes):
            return base64.b64encode(value.value).decode()
        return self._numbers_of(value)

    def _numbers_of(self, tagged: "CBORTag") -> list[float] | list[int]:
        numbers = _array(tagged)
        self._numbers += len(numbers)
        if self._numbers > MAX_NUMBERS:
            raise MessageTooLarge(f"the typed arrays of a frame have at most {MAX_NUMBERS} numbers together")
        found: list[float] | list[int] = numbers.tolist()
        return found


def _array(tagged: "CBORTag") -> NDArray[np.generic]:
    """Return the numbers of a typed array.

    Raises
    ------
    MalformedMessage
        The tag does not mark a typed array, or its content is not a whole number of its elements.
    """
    kind = ARRAY_TYPES.get(tagged.tag)
    if kind is None or not isinstance(tagged.value, bytes):
        raise MalformedMessage(f"tag {tagged.tag} of CBOR is not that of a typed array of bytes (RFC 8746)")
    try:
        return np.frombuffer(tagged.value, dtype=kind)
    except ValueError as error:
        raise MalformedMessage(f"a typed array with tag {tagged.tag} is cut off: {error}") from error


# -- messages with ``compression: cbor-raw`` ---------------------------------------------------------------------------


class RosType(NamedTuple):
    """Type of the messages of a subscription, in bytes of ROS 1 or of ROS 2.

    Parameters
    ----------
    name : str, optional
        Name as spelled in ROS 1; None for the type of the topic, which may not be known yet.
    ros2 : bool
    """

    name: str | None = None
    ros2: bool = False


Serialize: TypeAlias = Callable[[bytes, RosType], bytes]
"""Called with a message as JSON and its type; returns its bytes. Raises UnknownType, InvalidInput, MalformedMessage."""


def not_serialized(_message: bytes, _kind: RosType) -> bytes:
    """Raise ``InvalidInput``: messages are not serialized here."""
    raise InvalidInput("messages are not sent in bytes of ROS here")


def cbor_raw_frame(spelling: str, serialized: bytes, now: float) -> BinaryFrame:
    """Return the frame that publishes a message in bytes of ROS.

    Parameters
    ----------
    spelling : str
        Name of the topic as the client spells it.
    serialized : bytes
        The message.
    now : float
        Time of sending since the epoch [s].
    """
    import cbor2  # noqa: PLC0415  # needed only for clients of CBOR

    time = Time.of(now)
    content = {"secs": time.secs, "nsecs": time.nsecs, "bytes": serialized}
    return BinaryFrame(cbor2.dumps({"op": "publish", "topic": spelling, "msg": content}))
