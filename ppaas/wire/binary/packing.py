"""Packing of messages for a client: as JSON, as PNG, in CBOR, in bytes of ROS or as compact frames.

As PNG, the text of a frame becomes the bytes of an RGB image that is nearly square, padded with line feeds, which comes
in base64 in the operation ``png`` (``rosbridge_library/internal/pngcompression.py`` of
``RobotWebTools/rosbridge_suite``).
"""

import base64
import io
import json
import math
import re
from collections.abc import Callable
from functools import partial
from typing import Final, NamedTuple, TypeAlias

from ppaas.clock import Clock, epoch
from ppaas.errors import InvalidInput, MalformedMessage, PPaaSError
from ppaas.wire.binary.cbor import RosType, Serialize, cbor_frame, cbor_raw_frame, cbor_to_json, is_cbor, not_serialized
from ppaas.wire.binary.compact import compact_cmd_vel, compact_to_json, is_compact

# -- messages with ``compression: png`` --------------------------------------------------------------------------------

_NOT_ASCII: Final = re.compile(r"[^\x00-\x7f]")

_PIXEL: Final = 3
"""Size of a pixel [bytes]."""

_LEVEL: Final = 3
"""Level of zlib: 6 takes three times as long for messages that are a sixth smaller."""


def png_frame(frame: bytes) -> bytes:
    """Return the frame of ``png`` that contains a frame, which is JSON."""
    from PIL.Image import frombytes  # noqa: PLC0415  # Pillow is needed only for clients of PNG

    text = _ascii(frame)
    width = max(math.isqrt(len(text) // _PIXEL), 1)
    height = max(-(-len(text) // (_PIXEL * width)), 1)
    file = io.BytesIO()
    image = frombytes("RGB", (width, height), text.ljust(width * height * _PIXEL, b"\n"))
    image.save(file, "png", compress_level=_LEVEL)
    return b'{"op":"png","data":"%b"}' % base64.b64encode(file.getvalue())


def _ascii(frame: bytes) -> bytes:
    """Return a frame with other characters escaped: web pages read each byte of the image as a character."""
    if frame.isascii():
        return frame
    return _NOT_ASCII.sub(lambda character: json.dumps(character[0])[1:-1], frame.decode()).encode()


# -- packing of messages for a client ----------------------------------------------------------------------------------

Pack: TypeAlias = Callable[[str, bytes], bytes]
"""Called with the name of a topic as the client spells it, and a message as JSON; returns the frame to publish it."""


class Packing(NamedTuple):
    """How the messages of a subscription are packed; of several subscriptions, the highest rank counts."""

    rank: int
    pack: Pack


def json_frame(spelling: str, message: bytes) -> bytes:
    """Return the frame that publishes a message in JSON."""
    return b'{"op":"publish","topic":"%b","msg":%b}' % (spelling.encode(), message)


def _png(spelling: str, message: bytes) -> bytes:
    return png_frame(json_frame(spelling, message))


def _compact(_spelling: str, message: bytes) -> bytes:
    return compact_cmd_vel(message)


PLAIN: Final = Packing(0, json_frame)
COMPRESSIONS: Final = ("none", "png", "cbor", "cbor-raw")
"""Values of ``compression``, from the least to the most; of several subscriptions to a topic the most counts."""


CMD_VEL_TOPIC: Final = "cmd_vel"
"""Topic whose messages have a compact frame."""


_UNTYPED: Final = RosType()


class Packer:
    """Chooses the packing of each subscription of one client.

    Parameters
    ----------
    compact : bool
        Whether velocities are sent as compact frames to subscriptions without a compression.
    png : bool
        Whether the client reads ``png``. Clients that do not may ask for it all the same.
    serialize : callable
        Makes bytes of ROS of messages.
    now : callable
        Returns the time since the epoch [s].

    Attributes
    ----------
    type_of : callable
        Called with a topic; returns its type, or None.
    """

    def __init__(
        self, *, compact: bool = False, png: bool = True, serialize: Serialize = not_serialized, now: Clock = epoch
    ) -> None:
        self._compact = compact
        self._png = png
        self._serialize = serialize
        self._now = now
        self.type_of: Callable[[str], str | None] = lambda _topic: None

    def packing_of(self, topic: str, compression: str | None, kind: RosType = _UNTYPED) -> Packing:
        """Return the packing of a subscription to a topic; JSON if there is an `objection`.

        Parameters
        ----------
        topic : str
        compression : str, optional
            One of `COMPRESSIONS`.
        kind : RosType
            Type that the client named.
        """
        if self.objection(topic, compression, kind) is not None:
            compression = None
        if compression == "cbor-raw":
            return Packing(COMPRESSIONS.index("cbor-raw"), partial(self._raw, topic, kind))
        if compression == "cbor":
            return Packing(COMPRESSIONS.index("cbor"), partial(self._cbor, topic))
        if compression == "png" and self._png:
            return Packing(COMPRESSIONS.index("png"), _png)
        if self._compact and topic == CMD_VEL_TOPIC:
            return Packing(0, _compact)
        return PLAIN

    def objection(self, topic: str, compression: str | None, kind: RosType = _UNTYPED) -> PPaaSError | None:
        """Return the reason why a subscription gets JSON in place of its compression; None if it does not."""
        if compression == "cbor-raw":
            return self._not_serialized(self._typed(topic, kind))
        if not compression or compression in COMPRESSIONS:
            return None
        known = ", ".join(COMPRESSIONS)
        return InvalidInput(f"unknown compression {compression[:32]!r}: JSON is sent; known: {known}")

    def _not_serialized(self, kind: RosType) -> PPaaSError | None:
        """Return the reason why messages of a type cannot be sent in bytes of ROS; None if they can.

        An empty object is serialized to find out: fields that are missing have default values in each type.
        """
        try:
            self._serialize(b"{}", kind if kind.name is not None else kind._replace(name="std_msgs/Empty"))
        except PPaaSError as error:
            return type(error)(f"{error}; JSON is sent in place of cbor-raw")
        return None

    def _typed(self, topic: str, kind: RosType) -> RosType:
        return kind if kind.name is not None else kind._replace(name=self.type_of(topic))

    def _cbor(self, topic: str, spelling: str, message: bytes) -> bytes:
        return cbor_frame(spelling, message, self.type_of(topic))

    def _raw(self, topic: str, kind: RosType, spelling: str, message: bytes) -> bytes:
        return cbor_raw_frame(spelling, self._serialize(message, self._typed(topic, kind)), self._now())


def operation_of(frame: bytes) -> bytes:
    """Return the operation in a binary frame of a client as JSON; JSON is returned unchanged.

    Raises
    ------
    MalformedMessage
        It is neither JSON in UTF-8, CBOR, nor a compact frame.
    MessageTooLarge
        It is CBOR with too many items.
    """
    if len(frame) >= 5 and int.from_bytes(frame[:4], "little") == len(frame) and frame[-1] == 0:
        raise MalformedMessage("BSON is not supported: send JSON, CBOR or compact frames")
    if is_compact(frame):
        return compact_to_json(frame)
    if is_cbor(frame):
        return cbor_to_json(frame)
    try:
        frame.decode()
    except UnicodeDecodeError as error:
        raise MalformedMessage(
            "a binary frame must be JSON in UTF-8, CBOR of an operation, or a compact frame"
        ) from error
    return frame
