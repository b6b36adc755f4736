"""Messages as JSON: encoding, and decoding as rosbridge_suite does, with defaults and spellings of ROS 1 and ROS 2.

This module takes and refuses the same spellings as rosbridge_suite. Its errors say where the fault is and what to do:

============================  ==========================================================================================
a field is left out           its default in ROS: 0, false, empty; a message with its own defaults
null                          left out, where it stands for a message, a time, or a field of a header; no reading in
                              ranges; 0, which means unknown, in covariances; elsewhere refused, as NaN and infinity are
``"now"`` for a time          zero, which means now
``uint8[]``                   base64, with or without line breaks, or a list of numbers
``sec``, ``nanosec``          ``secs``, ``nsecs``
``d``, ``k``, ``r``, ``p``    ``D``, ``K``, ``R``, ``P`` of a CameraInfo
a TwistStamped for a Twist    its twist, as bases and joysticks of Nav2 send velocities; a Twist for a TwistStamped has
                              no frame and the time zero
a Goals for poses of Nav2     its goals, each in the frame of its header if it names none
an unknown field              refused, with the names of the fields
============================  ==========================================================================================

Source: ``rosbridge_library/internal/message_conversion.py`` of ``RobotWebTools/rosbridge_suite``.
"""

import base64
import binascii
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import TypeVar, cast

import msgspec
from msgspec import inspect

from ppaas.decoding import converted, describe
from ppaas.errors import MalformedMessage
from ppaas.messages.base.message import Message, message_of, plain, struct_of
from ppaas.messages.base.rosapi import GetParamRequest
from ppaas.messages.base.spelling import MAX_TOLERATED, read_json, to_ros1
from ppaas.messages.base.std_msgs import Duration, Header, Time
from ppaas.messages.geometry_msgs import Twist, TwistStamped
from ppaas.messages.nav2_msgs import ComputePathThroughPosesGoal, NavigateThroughPosesGoal
from ppaas.messages.nav_msgs import Goals
from ppaas.messages.sensor_msgs import CameraInfo

M = TypeVar("M", bound=Message)

MAX_WITH_BYTES = 16 << 20
"""Largest message with a field of bytes that is read [bytes of JSON]."""

OTHER_SPELLINGS: Mapping[type[Message], Mapping[str, str]] = {
    Time: {"sec": "secs", "nanosec": "nsecs"},
    Duration: {"sec": "secs", "nanosec": "nsecs"},
    CameraInfo: {"d": "D", "k": "K", "r": "R", "p": "P"},
    GetParamRequest: {"default_value": "default"},
}
"""Names of fields in ROS 2 that differ from ROS 1."""

LISTS_OF_GOALS: Mapping[type[Message], str] = {NavigateThroughPosesGoal: "poses", ComputePathThroughPosesGoal: "goals"}
"""Fields that are lists of poses in Nav2 before Kilted, and a ``nav_msgs/Goals`` since."""

COVARIANCE = 36
"""Length of the covariance matrix of a pose or a twist."""

_Read = Callable[[object, str], object]
"""Called with a value of JSON and its place in the message; returns the value in the strict form."""


_encoder = msgspec.json.Encoder()


@cache
def _decoder(cls: type[Message]) -> msgspec.json.Decoder[Message]:
    describe(cls)
    return msgspec.json.Decoder(cls)


def encode(message: Message) -> bytes:
    """Return the message as JSON; NaN and infinity become null."""
    return _encoder.encode(message)


def decode(cls: type[M], data: bytes | str | msgspec.Raw) -> M:
    """Decode a message of the given type, strictly or, if that fails, as tolerantly as rosbridge_suite.

    Raises
    ------
    MalformedMessage
        The data is not JSON, or not of that type; the text names the place in the message.
    """
    try:
        return cast(M, _decoder(cls).decode(data))
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        # Messages forbid unknown fields, so other spellings always get here, and other messages cost nothing more.
        return _decode_otherwise(cls, data.encode() if isinstance(data, str) else bytes(data))


def _decode_otherwise(cls: type[M], data: bytes) -> M:
    """Decode a message with the times of ROS 2, which many clients send, or else tolerantly, which takes longer."""
    if (respelled := to_ros1(data)) != data:
        try:
            return cast(M, _decoder(cls).decode(respelled))
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
            pass
    try:
        return decode_tolerantly(cls, data)
    except MalformedMessage as error:
        raise MalformedMessage(f"not a {cls.__name__}: {error}") from error


def decode_tolerantly(cls: type[M], data: bytes) -> M:
    """Decode a message of the given type.

    Raises
    ------
    MalformedMessage
        The data is not JSON, or not of that type; the text names the place in the message.
    """
    reader = _reader_of(cls)
    value = read_json(data, reader.limit)
    try:
        return converted(reader.read(_velocity(cls, value), "$"), cls)
    except RecursionError as error:
        raise MalformedMessage("it is nested too deeply") from error
    except msgspec.ValidationError as error:
        raise MalformedMessage(_explained(str(error))) from error


def _velocity(cls: type[Message], value: object) -> object:
    """Return a velocity with or without a header as the type that is expected; any other value unchanged."""
    if cls is Twist and isinstance(value, dict) and "twist" in value:
        return _reader_of(TwistStamped).read(value, "$")["twist"]
    if cls is TwistStamped and isinstance(value, dict) and not value.keys().isdisjoint(("linear", "angular")):
        return {"twist": value}
    return value


def _explained(text: str) -> str:
    if "got `null`" in text:
        return f"{text}; a number is needed here, and NaN and infinity are none"
    if "matching regex" in text or "length <= 255" in text:
        place = text.rpartition(" at ")[2]
        return f"the name of a frame has at most 255 characters, and no control characters - at {place}"
    return text


class _MessageReader:
    """Reader of one message type; ``limit`` is the size of the largest message that is read [bytes of JSON]."""

    def __init__(self, cls: type[Message]) -> None:
        described = struct_of(cls)
        self._cls = cls
        self._strict = described.forbid_unknown_fields
        self._fields = {field.encode_name: field for field in described.fields}
        has_bytes = any(isinstance(plain(field.type)[0], inspect.BytesType) for field in described.fields)
        self.limit = MAX_WITH_BYTES if has_bytes else MAX_TOLERATED
        self._names = {name: name for name in self._fields} | dict(OTHER_SPELLINGS.get(cls, {}))
        self._read = {name: _read_of(field.type) for name, field in self._fields.items()}
        if (poses := LISTS_OF_GOALS.get(cls)) is not None:
            self._read[poses] = partial(_read_goals, self._read[poses])
        self._missing = {name: _default_of(field.type) for name, field in self._fields.items() if field.required}
        self._null_is_left_out = {
            name for name, field in self._fields.items() if cls is Header or message_of(plain(field.type)[0])
        }

    def read(self, value: object, place: str) -> dict[str, object]:
        """Return the fields of a message in their strict form; a required field that is left out has its default."""
        if not isinstance(value, dict):
            raise MalformedMessage(f"expected an object with the fields of {self._cls.__name__} at `{place}`")
        fields: dict[str, object] = {}
        for key, item in value.items():
            name = self._names.get(key)
            if name is None:
                if self._strict:
                    raise MalformedMessage(self._unknown(key, place))
            elif item is not None or name not in self._null_is_left_out:
                read = self._read[name]
                fields[name] = item if read is None else read(item, f"{place}.{key}")
        for name, default in self._missing.items():
            if name not in fields and default is not None:
                fields[name] = default()
        return fields

    def _unknown(self, key: str, place: str) -> str:
        known = ", ".join(self._fields) or "none"
        return f"{self._cls.__name__} has no field {key[:64]!r} at `{place}`; its fields are: {known}"


_reader_of = cache(_MessageReader)


def _read_of(kind: inspect.Type) -> _Read | None:
    """Return the reader of values of a type; None if they are in their strict form already."""
    bare, length, _ = plain(kind)
    message = message_of(bare)
    if message in (Time, Duration):
        return partial(_read_time, message)
    if message is not None:
        return lambda value, place: _reader_of(message).read(value, place)
    if isinstance(bare, inspect.BytesType):
        return _read_bytes
    if isinstance(bare, inspect.ListType):
        if length == COVARIANCE:
            return _read_covariance
        item = _read_of(bare.item_type)
        return partial(_read_list, item) if item is not None else None
    return None


def _read_time(cls: type[Message], value: object, place: str) -> object:
    if value in ("now", None):
        return {}
    if not isinstance(value, dict):
        raise MalformedMessage(
            f'expected a time at `{place}`: {{"secs": …, "nsecs": …}}, {{"sec": …, "nanosec": …}}, or "now"'
        )
    return _reader_of(cls).read(value, place)


def _read_bytes(value: object, place: str) -> object:
    if not isinstance(value, str | list):
        raise MalformedMessage(f"expected bytes at `{place}`, as base64 or as a list of numbers from 0 to 255")
    try:
        return base64.b64decode(value) if isinstance(value, str) else bytes(value)
    except (binascii.Error, ValueError, TypeError) as error:
        raise MalformedMessage(f"no bytes at `{place}`: {error}") from error


def _read_covariance(value: object, _place: str) -> object:
    """Return a covariance whose unknown entries, which are null, are 0, as ROS writes what is unknown."""
    return [0.0 if item is None else item for item in value] if isinstance(value, list) else value


def _read_list(read: _Read, value: object, place: str) -> object:
    if not isinstance(value, list):
        return value
    return [read(item, f"{place}[{number}]") for number, item in enumerate(value)]


def _read_goals(read: _Read | None, value: object, place: str) -> object:
    """Return a list of poses, given as such or as a ``nav_msgs/Goals``; its header counts for poses without a frame."""
    assert read is not None, "poses are messages"
    if not isinstance(value, dict):
        return read(value, place)
    goals = _reader_of(Goals).read(value, place)
    for pose in cast(list[dict[str, dict[str, object]]], goals["goals"]):
        if not pose["header"].get("frame_id"):
            pose["header"] = cast(dict[str, object], goals["header"])
    return goals["goals"]


def _default_of(kind: inspect.Type) -> Callable[[], object] | None:
    """Return the maker of the default that a type has in ROS; None if it is not a type of ROS."""
    bare, length, _ = plain(kind)
    message = message_of(bare)
    if message is not None:
        return lambda: _reader_of(message).read({}, "$")
    if isinstance(bare, inspect.ListType):
        return lambda: [0.0] * max(length, 0)
    zero = _ZERO.get(type(bare))
    return None if zero is None else lambda: zero


_ZERO: dict[type[inspect.Type], object] = {
    inspect.FloatType: 0.0,
    inspect.IntType: 0,
    inspect.BoolType: False,
    inspect.StrType: "",
    inspect.BytesType: b"",
}
