"""Forwarder: messages as the bytes of ROS 1, compressed by zlib.

Source: ``_ForwarderBase`` in ``rce/monitor/interface/robot.py``.
"""

import zlib
from typing import Any

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge

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
    stream = zlib.decompressobj()
    try:
        serialized = stream.decompress(data, MAX_SERIALIZED)
    except zlib.error as error:
        raise MalformedMessage(f"the message of a forwarder is not compressed by zlib: {error}") from error
    if stream.unconsumed_tail:
        raise MessageTooLarge(f"the message of a forwarder has more than {MAX_SERIALIZED >> 20} MiB")
    if not stream.eof:
        raise MalformedMessage("the message of a forwarder is not complete: its zlib stream does not end")
    return serialized
