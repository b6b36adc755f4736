"""Messages of interfaces on robots: what a robot sends and receives in a DM, and the JSON that the clone uses.

A converter has JSON, with times as ``YYYY-MM-DDTHH:MM:SS.mmmmmm`` (UTC) and durations as seconds; a forwarder has the
bytes of ROS 1, compressed by zlib.

Source: ``rce/util/converter.py`` and ``rce/monitor/interface/robot.py``.

The converter gives JSON of 2013:

=====================  =============================================================================================
ROS                    JSON
=====================  =============================================================================================
time                   ``YYYY-MM-DDTHH:MM:SS.mmmmmm`` in UTC; from the robot also ``secs``, ``nsecs``
duration               seconds as a number; from the robot also ``secs``, ``nsecs``
uint8[]                a binary part; from the robot also base64 or a list
numbers[]              a list; from the robot also a binary part: the numbers as ROS serializes them, little endian
NaN, infinity          null; from the robot also ``NaN``, ``Infinity``
=====================  =============================================================================================

Binary parts of numbers, and of ``uint8[]`` other than images, are an extension: rce knew parts of images only. The
forwarder gives the bytes of ROS 1, compressed by zlib (``_ForwarderBase`` in ``rce/monitor/interface/robot.py``).
"""

import base64
import math
import zlib
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from functools import cache
from typing import Any, Protocol

import msgspec
import numpy as np
from msgspec import inspect

from ppaas.bounded import inflated
from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge, UnknownType
from ppaas.messages.base.message import Message, message_of, plain, struct_of
from ppaas.messages.base.std_msgs import Duration, Time
from ppaas.messages.registry import message_type, service_type
from ppaas.wire.names import ros1_type
from ppaas.wire.rapyuta.interface_types import InterfaceForm, InterfaceRole, InterfaceType

# -- converter ---------------------------------------------------------------------------------------------------------

TIME_FORMAT = "%Y-%m-%dT%H:%M:%S.%f"
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)

Read = Callable[[Any, str], Any]
"""Called with a value of the robot and its place in the message; returns the value of rosbridge's JSON."""

Write = Callable[[Any], Any]
"""Called with a value of rosbridge's JSON; returns the value for the robot."""

_DTYPES = {
    "float32": "<f4", "float64": "<f8", "int8": "<i1", "int16": "<i2", "int32": "<i4", "uint8": "<u1", "uint16": "<u2",
    "uint32": "<u4",
}  # fmt: skip
_DEFAULTS = {inspect.FloatType: "float64", inspect.IntType: "int32"}
_encoder = msgspec.json.Encoder()


class Converter:
    """Converter of one type of messages.

    Parameters
    ----------
    kind : type of Message, optional
        The type; messages of an unknown one pass as they are, with binary parts as base64.
    """

    def __init__(self, kind: type[Message] | None) -> None:
        self._fields = None if kind is None else _fields(kind)

    def read(self, message: Any) -> bytes:
        """Return a message of the robot as JSON of rosbridge.

        Raises
        ------
        MalformedMessage
            It is not an object, or a time, a duration or a part in it is invalid.
        """
        if not isinstance(message, dict):
            raise MalformedMessage(
                "Sent message is not an object with the fields of its type; images go as sensor_msgs/CompressedImage"
            )
        value = _without_bytes(message) if self._fields is None else _read_message(self._fields, message, "$")
        return _encoder.encode(_without_bytes(value))

    def write(self, payload: bytes) -> Any:
        """Return a message for the robot; bytes in it are binary parts.

        Values that are not of their type, as a client may publish them, stay as they are; times among them are 0.
        """
        message = msgspec.json.decode(payload)
        if self._fields is None or not isinstance(message, dict):
            return message
        return _write_message(self._fields, message)


class _Field:
    """Reader and writer of the values of one field; None where they are the same on both sides."""

    def __init__(self, read: Read | None, write: Write | None) -> None:
        self.read = read
        self.write = write


@cache
def _fields(kind: type[Message]) -> dict[str, _Field]:
    described = {field.encode_name: _field(field.type) for field in struct_of(kind).fields}
    return {name: field for name, field in described.items() if field is not None}


def _field(kind: inspect.Type) -> _Field | None:
    bare, _, _ = plain(kind)
    message = message_of(bare)
    if message is Time:
        return _Field(_read_time, _write_time)
    if message is Duration:
        return _Field(_read_duration, _write_duration)
    if message is not None:
        return _Field(
            lambda value, place: _read_message(_fields(message), value, place),
            lambda value: _write_message(_fields(message), value),
        )
    if isinstance(bare, inspect.BytesType):
        return _Field(None, _write_bytes)
    return _list_field(bare.item_type) if isinstance(bare, inspect.ListType) else None


def _list_field(kind: inspect.Type) -> _Field | None:
    bare, _, ros = plain(kind)
    name = ros or _DEFAULTS.get(type(bare), "")
    if name in _DTYPES:
        dtype = np.dtype(_DTYPES[name])
        return _Field(lambda value, place: _read_numbers(dtype, value, place), None)
    item = _field(kind)
    if item is None or item.read is None or item.write is None:
        return None
    read, write = item.read, item.write
    return _Field(
        lambda values, place: [read(v, f"{place}[{n}]") for n, v in enumerate(values)] if _is_list(values) else values,
        lambda values: [write(value) for value in values] if _is_list(values) else values,
    )


def _is_list(value: object) -> bool:
    return isinstance(value, list)


def _read_message(fields: dict[str, _Field], value: Any, place: str) -> Any:
    if not isinstance(value, dict):
        return value  # the clone says what is wrong
    read = {name: field.read for name, field in fields.items() if field.read is not None and name in value}
    return value | {name: convert(value[name], f"{place}.{name}") for name, convert in read.items()}


def _write_message(fields: dict[str, _Field], value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    write = {name: field.write for name, field in fields.items() if field.write is not None and name in value}
    return value | {name: convert(value[name]) for name, convert in write.items()}


def _read_time(value: Any, place: str) -> Any:
    if not isinstance(value, str):
        return value
    try:
        moment = datetime.fromisoformat(value)
        moment = moment.replace(tzinfo=UTC) if moment.tzinfo is None else moment
        microseconds = (moment - EPOCH) // timedelta(microseconds=1)
    except (ValueError, OverflowError) as error:
        raise MalformedMessage(f"no time at `{place}`: write YYYY-MM-DDTHH:MM:SS.mmmmmm, not {value[:40]!r}") from error
    return {"secs": microseconds // 10**6, "nsecs": microseconds % 10**6 * 1000}


def _write_time(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    try:
        moment = EPOCH + timedelta(seconds=value.get("secs", 0), microseconds=value.get("nsecs", 0) // 1000)
        return moment.strftime(TIME_FORMAT)
    except (TypeError, ValueError, OverflowError):
        return EPOCH.strftime(TIME_FORMAT)


def _read_duration(value: Any, place: str) -> Any:
    try:
        seconds = float(value) if isinstance(value, int | float | str) else None
    except (ValueError, OverflowError) as error:
        raise MalformedMessage(f"no duration at `{place}`: write seconds as a number, not {value!r:.40}") from error
    if seconds is None:
        return value
    if not math.isfinite(seconds):
        raise MalformedMessage(f"no duration at `{place}`: it is not finite")
    whole = math.floor(seconds)
    return {"secs": whole, "nsecs": int((seconds - whole) * 1e9)}


def _write_duration(value: Any) -> Any:
    try:
        return value.get("secs", 0) + value.get("nsecs", 0) * 1e-9 if isinstance(value, dict) else value
    except (TypeError, OverflowError):
        return 0.0


def _write_bytes(value: Any) -> Any:
    try:
        return base64.b64decode(value) if isinstance(value, str) else value
    except ValueError:
        return value


def _read_numbers(dtype: "np.dtype[Any]", value: Any, place: str) -> Any:
    if not isinstance(value, bytes):
        return value
    if len(value) % dtype.itemsize:
        raise MalformedMessage(
            f"the binary part of `{place}` has {len(value)} bytes, which are not numbers of {dtype.itemsize} bytes"
        )
    return np.frombuffer(value, dtype).tolist()


def _without_bytes(value: Any) -> Any:
    """Return a value with base64 in place of bytes."""
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    if isinstance(value, dict):
        return {key: _without_bytes(item) for key, item in value.items()}
    if isinstance(value, list) and any(isinstance(item, bytes | dict | list) for item in value):
        return [_without_bytes(item) for item in value]
    return value


# -- forwarder ---------------------------------------------------------------------------------------------------------

LEVEL = 9
"""Compression level, as in rce."""

MAX_SERIALIZED = 16 << 20
"""Largest message without compression [bytes]."""


class Forwarder:
    """Codec of one type of messages in the serialization of ROS 1.

    Parameters
    ----------
    name : str
        Type of the messages, by its name in ROS; of a service ``package/srv/Name_Request`` or ``_Response``.

    Raises
    ------
    InvalidInput
        The definition of the type is not known, or the library that serializes is not installed.
    """

    def __init__(self, name: str) -> None:
        # rosbags, which serializes, is part of an extra.
        from ppaas.wire.ros import ros_types  # noqa: PLC0415

        try:
            self._types = ros_types("noetic")
        except ImportError as error:
            raise InvalidInput(f"forwarders are not available in this cloud: {error}") from error
        if name not in self._types:
            raise InvalidInput(
                f"the definition of {name} is not known, which a forwarder needs: use a converter for this interface"
            )
        self._name = name

    def read(self, message: Any) -> bytes:
        """Return a message of the robot as JSON of rosbridge.

        Raises
        ------
        MalformedMessage
            It is not a binary part, not compressed by zlib, or not of this type.
        MessageTooLarge
            It has more than `MAX_SERIALIZED` bytes.
        """
        if not isinstance(message, bytes):
            raise MalformedMessage("Sent message is not a binary message.")
        return self._types.decode_json(self._name, _decompress(message))

    def write(self, payload: bytes) -> Any:
        """Return a message as a binary part for the robot."""
        return zlib.compress(self._types.encode_json(self._name, payload), LEVEL)


def _decompress(data: bytes) -> bytes:
    try:
        return inflated(data, MAX_SERIALIZED)
    except zlib.error as error:
        raise MalformedMessage(f"the message of a forwarder is not packed by zlib: {error}") from error
    except OverflowError as error:
        raise MessageTooLarge(f"the message of a forwarder has more than {MAX_SERIALIZED >> 20} MiB") from error


# -- messages of interfaces on robots ----------------------------------------------------------------------------------

CLASSES = {"tf/tfMessage": "tf2_msgs/TFMessage"}
"""Classes of 2013 that have another name now."""


class MessageCodec(Protocol):
    """Codec of the messages in one direction of an interface on a robot."""

    def read(self, message: Any) -> bytes:
        """Return a message of the robot as JSON; raises ``MalformedMessage`` if it is not one."""
        ...

    def write(self, payload: bytes) -> Any:
        """Return a message as the robot expects it, from JSON; bytes in it are binary parts."""
        ...


def graph_class(name: str) -> str:
    """Return a class of messages or services by its name in the graph of the clone.

    Raises
    ------
    UnknownType
        It is not the name of a type of ROS.
    """
    return ros1_type(CLASSES.get(name, name))


def codecs_of(kind: InterfaceType, class_name: str) -> tuple[MessageCodec, MessageCodec]:
    """Return the codecs of what an interface on a robot sends, and of what it receives.

    For a topic both are the same. A client of a service receives requests and sends responses; a provider sends
    requests and receives responses.

    Raises
    ------
    InvalidInput
        The interface belongs to a container.
    UnknownType
        The class is not known, and needed.
    """
    if kind.form is InterfaceForm.INTERFACE:
        raise InvalidInput(f"an interface on a robot is a converter or a forwarder, not {kind}")
    name = graph_class(class_name)
    if not kind.is_service:
        codec = _codec(kind.form, name, _message(name))
        return codec, codec
    request, response = _service(kind.form, name)
    return (response, request) if kind.role is InterfaceRole.SERVICE_CLIENT else (request, response)


def _service(form: InterfaceForm, name: str) -> tuple[MessageCodec, MessageCodec]:
    try:
        known = service_type(name)
    except UnknownType:
        request = response = None
    else:
        request, response = known.request, known.response
    package, _, short = name.partition("/")
    full = f"{package}/srv/{short}"
    return _codec(form, f"{full}_Request", request), _codec(form, f"{full}_Response", response)


def _codec(form: InterfaceForm, name: str, cls: type[Message] | None) -> MessageCodec:
    return Converter(cls) if form is InterfaceForm.CONVERTER else Forwarder(name)


def _message(name: str) -> type[Message] | None:
    try:
        return message_type(name)
    except UnknownType:
        return None  # of a topic of the robot's own, whose messages pass as they are
