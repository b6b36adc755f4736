"""Messages to robots: DM, ST and ER, as frames.

Source: ``RobotWebSocketProtocol`` in ``rce/comm/server.py``.
"""

from typing import Any, NamedTuple

import msgspec

from ppaas.errors import Conflict, InvalidInput, NotFound, NotPermitted, PPaaSError
from ppaas.wire.rapyuta.part_assembler import with_references

MAX_ERROR = 4096
"""Longest text of an error [characters]."""

INVALID = "Invalid Request: "
"""Beginning of the text of an error that the robot made."""

INTERFACE_UPDATE = "iu"
"""Topic of the status of interfaces."""

_LENGTH = 4
_encoder = msgspec.json.Encoder()


class AnswerFrames(NamedTuple):
    """Text frame, and the binary frames that follow it."""

    text: bytes
    parts: tuple[bytes, ...] = ()

    def packed(self) -> bytes:
        """Return the frames as one block of bytes, each after its length, for queues."""
        return b"".join(len(frame).to_bytes(_LENGTH) + frame for frame in (self.text, *self.parts))

    @staticmethod
    def unpack(block: bytes) -> "AnswerFrames":
        """Return the frames of a block that ``packed`` returned."""
        frames, at = [], 0
        while at < len(block):
            end = at + _LENGTH + int.from_bytes(block[at : at + _LENGTH])
            frames.append(block[at + _LENGTH : end])
            at = end
        return AnswerFrames(frames[0], tuple(frames[1:]))


def data_message(interface: str, kind: str, message_id: str, message: Any) -> AnswerFrames:
    """Return a DM of an interface.

    Parameters
    ----------
    interface, kind, message_id : str
        Tag of the interface, its class, and the id of the message.
    message : dict or bytes
        The message; bytes in it are sent as binary parts.
    """
    data, parts = with_references({"iTag": interface, "type": kind, "msgID": message_id, "msg": message})
    return AnswerFrames(_encoder.encode({"type": "DM", "data": data}), tuple(parts))


def interface_status(interface: str, *, active: bool) -> AnswerFrames:
    """Return a ST: whether an interface of the robot is connected to another one."""
    data = {"topic": INTERFACE_UPDATE, "iTag": interface, "status": active}
    return AnswerFrames(_encoder.encode({"type": "ST", "data": data}))


def error_message(error: PPaaSError) -> AnswerFrames:
    """Return an ER; the text of an error that the robot can mend begins with ``Invalid Request:``."""
    mended = isinstance(error, InvalidInput | NotFound | Conflict | NotPermitted)
    text = error.public if not mended or error.public.startswith(INVALID) else f"{INVALID}{error.public}"
    return AnswerFrames(_encoder.encode({"type": "ER", "data": text[:MAX_ERROR]}))
