"""Messages that Foxglove's clients publish, as JSON of rosbridge: they come as JSON, CDR or in the bytes of ROS 1."""

from typing import Any

from ppaas.errors import InvalidInput
from ppaas.wire.foxglove.answers import ENCODINGS
from ppaas.wire.foxglove.conversion.base import SharedFrames, read_object
from ppaas.wire.ros.own_types import types_with
from ppaas.wire.ros.types import ROS_1, ros_types, to_json


def check_encoding(encoding: str) -> None:
    """Raise ``InvalidInput`` unless messages in an encoding can be read."""
    if encoding not in ENCODINGS:
        raise InvalidInput(f"messages in {encoding[:32]!r} are not read; publish in one of {', '.join(ENCODINGS)}")


def read_published(encoding: str, kind: str, data: bytes, frames: SharedFrames) -> bytes:
    """Return a message as JSON, with the frames of the robot.

    Parameters
    ----------
    encoding : str
        One of ``ENCODINGS``.
    kind : str
        Type of the message, as spelled in ROS 1.
    data : bytes
    frames : SharedFrames

    Raises
    ------
    InvalidInput
        The encoding is another one, or the type is unknown, or the message is not of its type.
    """
    check_encoding(encoding)
    if encoding == "json":
        values = _read_json(kind, data)
    else:
        values = (types_with(kind) if encoding == "cdr" else ros_types(ROS_1)).decode(kind, data)
    frames.own_all(values)
    return to_json(values)


def read_called(encoding: str, service: str, data: bytes) -> bytes:
    """Return the request of a call as JSON of rosbridge.

    Raises
    ------
    InvalidInput
        The encoding is not JSON.
    MalformedMessage
        The request is not an object of JSON.
    """
    if encoding != "json":
        raise InvalidInput(f"calls are JSON, not {encoding[:32]!r}")
    return to_json(_read_json(f"request of {service}", data))


def _read_json(kind: str, data: bytes) -> dict[str, Any]:
    values = read_object(kind, data)
    _respell_times(values)
    return values


def _respell_times(values: Any) -> None:
    """Spell times as ROS 1 does; Foxglove writes ``sec`` and ``nsec``."""
    waiting = [values]
    while waiting:
        value = waiting.pop()
        if isinstance(value, list):
            waiting.extend(value)
        elif isinstance(value, dict):
            if value.keys() == {"sec", "nsec"}:
                value["secs"], value["nsecs"] = value.pop("sec"), value.pop("nsec")
            waiting.extend(value.values())
