"""TCPROS: how nodes of ROS 1 send messages to each other over TCP.

A connection begins with a header of each side; then messages follow. Each header and each message has its length in
front, as all lengths in 32 bits, little endian. A header is a list of fields, each with its length: ``key=value``.

The response to a request of a service has one byte more in front: 1, or 0 if text about a failure follows.

Source: https://wiki.ros.org/ROS/TCPROS and https://wiki.ros.org/ROS/Connection%20Header.
"""

import struct
from collections.abc import Mapping
from typing import Final

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge
from ppaas.wire.ros.types import RosTypes

MAX_HEADER: Final = 256 << 10
"""Largest header that is read [bytes]: the definition of a message in it may be long."""

MAX_FIELDS: Final = 64
"""Largest number of fields in a header."""

ANY: Final = "*"
"""Type, or sum of a type, that matches all."""

_LENGTH = struct.Struct("<I")


def framed(data: bytes) -> bytes:
    """Return a header or a message with its length in front."""
    return _LENGTH.pack(len(data)) + data


def answered(data: bytes, *, ok: bool = True) -> bytes:
    """Return the response to a request of a service as it is sent: a message, or the text of a failure."""
    return bytes((ok,)) + framed(data)


def pack_header(fields: Mapping[str, str]) -> bytes:
    """Return a header, without its length in front."""
    return b"".join(framed(f"{key}={value}".encode()) for key, value in fields.items())


def unpack_header(data: bytes) -> dict[str, str]:
    """Return the fields of a header, given without its length in front.

    Raises
    ------
    MessageTooLarge
        The header has more than `MAX_HEADER` bytes or `MAX_FIELDS` fields.
    MalformedMessage
        A field ends behind the header, has no ``=``, or is not UTF-8.
    """
    if len(data) > MAX_HEADER:
        raise MessageTooLarge(f"a connection header of {len(data)} bytes; at most {MAX_HEADER} are read")
    fields: dict[str, str] = {}
    start = 0
    while start < len(data):
        if len(fields) == MAX_FIELDS:
            raise MessageTooLarge(f"a connection header of more than {MAX_FIELDS} fields")
        end = start + _LENGTH.size
        end += _LENGTH.unpack_from(data, start)[0] if end <= len(data) else 0
        if end > len(data):
            raise MalformedMessage(f"a connection header whose field at byte {start} is cut off")
        key, equals, value = data[start + _LENGTH.size : end].partition(b"=")
        if not equals:
            raise MalformedMessage(f"a connection header whose field at byte {start} has no '='")
        try:
            fields[key.decode()] = value.decode()
        except UnicodeDecodeError as error:
            raise MalformedMessage(f"a connection header whose field at byte {start} is not UTF-8") from error
        start = end
    return fields


class FrameReader:
    """Reads headers and messages from the bytes of a connection, however they were cut."""

    def __init__(self) -> None:
        self._data = bytearray()

    def feed(self, data: bytes) -> None:
        """Take bytes that have arrived."""
        self._data += data

    def take(self, limit: int) -> bytes | None:
        """Return the next header or message, and forget it; None if it is not complete.

        Raises
        ------
        MessageTooLarge
            It has more than ``limit`` bytes. The connection must be closed: nothing after it can be read.
        """
        if len(self._data) < _LENGTH.size:
            return None
        (length,) = _LENGTH.unpack_from(self._data)
        if length > limit:
            raise MessageTooLarge(f"{length} bytes over TCPROS; at most {limit} are read here")
        end = _LENGTH.size + length
        if len(self._data) < end:
            return None
        data = bytes(memoryview(self._data)[_LENGTH.size : end])
        del self._data[:end]
        return data


def publisher_header(types: RosTypes, node: str, topic: str, type_name: str, *, latching: bool) -> dict[str, str]:
    """Return the header by which a publisher answers a subscriber; the name of the type is spelled as in ROS 1."""
    return {
        "callerid": node,
        "topic": topic,
        "type": type_name,
        "md5sum": types.md5(type_name),
        "latching": str(int(latching)),
        "message_definition": types.definition(type_name),
    }


def subscriber_header(types: RosTypes, node: str, topic: str, type_name: str) -> dict[str, str]:
    """Return the header by which a subscriber asks for a topic; the name of the type is spelled as in ROS 1."""
    return {
        "callerid": node,
        "topic": topic,
        "type": type_name,
        "md5sum": types.md5(type_name),
        "message_definition": types.definition(type_name),
        "tcp_nodelay": "1",
    }


def server_header(types: RosTypes, node: str, type_name: str) -> dict[str, str]:
    """Return the header by which a server of a service answers a client."""
    return {
        "callerid": node,
        "type": type_name,
        "md5sum": types.md5(_service(type_name)),
        "request_type": f"{type_name}Request",
        "response_type": f"{type_name}Response",
    }


def check_peer(types: RosTypes, fields: Mapping[str, str], type_name: str, *, service: bool = False) -> None:
    """Check that the other side of a connection means the same type.

    Raises
    ------
    InvalidInput
        The other side reports an error, or its type has another sum; the text says what to do.
    """
    if "error" in fields:
        raise InvalidInput(f"the node refused: {fields['error'][:500]}")
    expected = types.md5(_service(type_name) if service else type_name)
    md5 = fields.get("md5sum", "")
    if md5 not in (expected, ANY):
        other = fields.get("type") or "a type without a name"
        raise InvalidInput(
            f"the node has {other} with md5sum {md5[:64] or '(none)'}, not {type_name} with {expected}: "
            "build the node with the message packages of ROS Noetic"
        )


def _service(type_name: str) -> str:
    """Return the name of a service, spelled as in ROS 1, as `RosTypes` has it."""
    package, _, name = type_name.partition("/")
    return f"{package}/srv/{name}"
