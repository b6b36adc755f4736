"""Conversion of the messages of one type, the reading of any type, and the frames of robots in one tree."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import msgspec

from ppaas.errors import MalformedMessage
from ppaas.nodes.frames import MAP
from ppaas.wire.foxglove.answers import Schema

FRAMES = ("frame_id", "child_frame_id")
"""Fields that name a frame."""


@dataclass(frozen=True, slots=True)
class SharedFrames:
    """Names of a robot's frames in the tree of all robots.

    Parameters
    ----------
    robot : str
        Name of the robot, below which its frames are.
    map : str
        Name of the frame of the map it is on; empty for its own map, which it makes.
    """

    robot: str
    map: str = ""

    def shared(self, frame: str) -> str:
        """Return a frame of the robot as it is named in the tree; no frame stays none."""
        name = frame.lstrip("/")
        if name == MAP and self.map:
            return self.map
        return name if not name or name.startswith(f"{self.robot}/") else f"{self.robot}/{name}"

    def own(self, frame: str) -> str:
        """Return a frame of the tree as the robot names it."""
        name = frame.lstrip("/")
        return MAP if self.map and name == self.map else name.removeprefix(f"{self.robot}/")

    def share_all(self, values: Any) -> None:
        """Rename the frames in a message, given as a dict."""
        _rename(values, self.shared)

    def own_all(self, values: Any) -> None:
        """Rename the frames in a message for the robot, given as a dict."""
        _rename(values, self.own)


def _rename(values: Any, rename: Any) -> None:
    """Rename the frames in a dict, and in the dicts and lists of dicts in it."""
    waiting = [values]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            for key, inner in value.items():
                if key in FRAMES and isinstance(inner, str):
                    value[key] = rename(inner)
                elif isinstance(inner, dict | list):
                    waiting.append(inner)
        elif value and isinstance(value[0], dict):
            waiting.extend(value)


_decoder = msgspec.json.Decoder()


class Conversion(NamedTuple):
    """Conversion of messages, given as JSON of rosbridge, to the encoding of a schema.

    ``convert`` raises ``MalformedMessage`` if the message is not of its type.
    """

    schema: Schema
    convert: Callable[[bytes, SharedFrames], bytes]


def read_object(kind: str, payload: bytes) -> dict[str, Any]:
    """Return a message given as JSON as a dict; raises ``MalformedMessage`` if it is not an object of JSON."""
    try:
        values = _decoder.decode(payload)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise MalformedMessage(f"not a {kind}: not JSON: {error}") from error
    if not isinstance(values, dict):
        raise MalformedMessage(f"not a {kind}: not an object")
    return values
