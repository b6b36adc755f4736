"""Spelling of messages: times of ROS 1 (``secs``) and ROS 2 (``sec``), and JSON beyond the standard.

The matrices of a ``CameraInfo``, which have small letters in ROS 2, are converted too.

Inside the cloud, messages use the keys of ROS 1. The JSON text is converted without parsing: a quoted word followed by
a colon can only be a key, since quotes within a string have a backslash before them. The backslash also excludes a
longer key whose last characters look like one of these keys.
"""

import json
import re
from typing import Final

import msgspec

from ppaas.errors import MalformedMessage

_KEY_OF_ROS1: Final = re.compile(rb'"(n?)secs"(?<!\\"secs")(?<!\\"nsecs")(?=\s*:)')
_KEY_OF_ROS2: Final = re.compile(rb'"(nano)?sec"(?<!\\"sec")(?<!\\"nanosec")(?=\s*:)')

_MATRIX_OF_ROS1: Final = re.compile(rb'(?<!\\)"([DKRP])"(?=\s*:)')


def to_ros2(payload: bytes) -> bytes:
    """Return a JSON message with the time keys of ROS 1 replaced by the keys of ROS 2."""
    return _KEY_OF_ROS1.sub(lambda key: b'"nanosec"' if key[1] else b'"sec"', payload)


def camera_to_ros2(payload: bytes) -> bytes:
    """Return a ``CameraInfo`` as JSON with the keys of ROS 2."""
    return _MATRIX_OF_ROS1.sub(lambda key: b'"%b"' % key[1].lower(), to_ros2(payload))


def to_ros1(payload: bytes) -> bytes:
    """Return a JSON message with the time keys of ROS 2 replaced by the keys of ROS 1."""
    return _KEY_OF_ROS2.sub(lambda key: b'"nsecs"' if key[1] else b'"secs"', payload)


MAX_TOLERATED = 1 << 20
"""Largest text that is read [bytes]: a scan of 100000 ranges, all of them ``Infinity``."""

MAX_VALUES, MAX_OBJECTS = 250_000, 20_000
"""Largest numbers of values, and of objects, lists and names among them; with `MAX_TOLERATED` they bound the time."""

_SPACE = re.compile(r"[\ufeff \t\r\n]*")
_LONG_NUMBER = re.compile(rb"(?<![0-9])[0-9]{400}")  # only from the first digit on: each run is tried once
"""More digits than any float has; the time of reading an integer grows with the square of its digits."""

_decoder = json.JSONDecoder(strict=False)
_encoder = msgspec.json.Encoder()


def to_standard_json(text: str | bytes, limit: int = MAX_TOLERATED) -> bytes:
    """Return a JSON text as the standard has it, with null for numbers that are not finite.

    Raises
    ------
    MalformedMessage
        The text is not JSON, is not UTF-8, is nested too deeply, or is larger than ``limit`` [bytes].
    """
    data = text.encode(errors="replace") if isinstance(text, str) else text
    if len(data) > limit or _is_complex(data):
        raise MalformedMessage(
            f"not standard JSON, and larger than {limit >> 10} KiB or too complex: write NaN and infinity as null"
        )
    try:
        plain = text if isinstance(text, str) else text.decode()
        return _encoder.encode(_decoder.decode(plain.removeprefix("\ufeff")))
    except RecursionError as error:
        raise MalformedMessage("JSON is nested too deeply") from error
    except (ValueError, OverflowError) as error:  # also JSONDecodeError, UnicodeError, and integers of many digits
        raise MalformedMessage(f"not JSON: {error}") from error


def split_json(text: str | bytes, most: int) -> list[str]:
    """Return the JSON texts of which a text consists one after the other, without what separates them.

    Returns
    -------
    list of str
        Empty if the text is too large or complex, is not JSON, or consists of more than ``most`` texts.
    """
    data = text.encode(errors="replace") if isinstance(text, str) else text
    if len(data) > MAX_TOLERATED or _is_complex(data):
        return []
    plain = data.decode(errors="replace")
    found: list[str] = []
    at = _begin(plain, 0)
    try:
        while at < len(plain) and len(found) < most:
            _, end = _decoder.raw_decode(plain, at)
            found.append(plain[at:end])
            at = _begin(plain, end)
    except (ValueError, RecursionError):
        return []
    return found if at == len(plain) else []


def _begin(text: str, at: int) -> int:
    found = _SPACE.match(text, at)
    return at if found is None else found.end()


def _is_complex(data: bytes) -> bool:
    objects = data.count(b"[") + data.count(b"{") + data.count(b'"') // 2
    return objects > MAX_OBJECTS or data.count(b",") > MAX_VALUES or _LONG_NUMBER.search(data) is not None


def read_json(data: bytes, limit: int = MAX_TOLERATED) -> object:
    """Return the value of a JSON text, with None for numbers that are not finite.

    Raises
    ------
    MalformedMessage
        As ``to_standard_json`` does.
    """
    if len(data) > limit:
        raise MalformedMessage(
            f"larger than {limit >> 10} KiB, and not in the form that the definition of its type has"
        )
    try:
        return msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeError, RecursionError):
        return msgspec.json.decode(to_standard_json(data, limit))
