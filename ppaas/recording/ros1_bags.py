"""Reads bags of ROS 1, also those that are cut off or not indexed: their records in the order of the file.

Source: http://wiki.ros.org/Bags/Format/2.0. The index is not used, since a recorder that was killed writes none.
"""

import bz2
import struct
from collections.abc import Callable, Iterator
from io import BytesIO
from typing import IO, Final

from ppaas.errors import MalformedMessage, MessageTooLarge
from ppaas.recording.reader import RecordedChannel, RecordedMessage, expand_lz4

MAGIC: Final = b"#ROSBAG V2.0\n"
OLD_MAGIC: Final = b"#ROSBAG V1."
_MESSAGE, _HEADER, _CHUNK, _CHUNK_INFO, _CONNECTION = 2, 3, 5, 6, 7
"""Values of the field ``op`` of the records that are read."""

MOST_HEADER: Final = 1 << 20
"""Largest header of a record [bytes]."""

MOST_DATA: Final = 256 << 20
"""Largest record, and largest chunk after decompression [bytes]."""

_SIZE = struct.Struct("<I")
_TIME = struct.Struct("<II")

_Fields = dict[bytes, bytes]


class Ros1BagReader:
    """Reader of one bag.

    Parameters
    ----------
    stream : binary stream
        Opened for reading, at its begin.

    Attributes
    ----------
    cut : bool
        Whether the bag ends before its end, as far as read: its recorder did not finish it.

    Raises
    ------
    MalformedMessage
        It is not a bag of ROS 1.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self._channels: dict[int, RecordedChannel] = {}
        self._chunks = self._indexed = False
        self.cut = False
        magic = stream.read(len(MAGIC))
        if magic.startswith(OLD_MAGIC):
            raise MalformedMessage("it has the format 1.x of bags; convert it by: rosbag fix")
        if magic != MAGIC:
            raise MalformedMessage("not a bag of ROS 1: its first bytes are others")

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield the messages in the order of the file.

        Raises
        ------
        MalformedMessage
            A record is damaged, or the bag is encrypted.
        MessageTooLarge
            A record or a chunk exceeds its limit.
        """
        for kind, fields, data in self._records(self._stream):
            if kind != _CHUNK:
                yield from self._take(kind, fields, data)
                continue
            self._chunks = True
            if not data and fields.get(b"compression") != b"none":
                break  # the recorder did not finish this chunk: compressed bytes follow, whose number is not known
            for inner in self._records(BytesIO(_expanded(fields, data))):
                yield from self._take(*inner)
        self.cut = self.cut or (self._chunks and not self._indexed)

    def _take(self, kind: int, fields: _Fields, data: bytes) -> Iterator[RecordedMessage]:
        """Note what a record says; yield it if it is a message."""
        if kind == _MESSAGE:
            number = _whole(fields, b"conn")
            if number not in self._channels:
                raise MalformedMessage(f"a message names connection {number}, which is missing")
            seconds, rest = _TIME.unpack(_field(fields, b"time", _TIME.size))
            at = seconds * 10**9 + rest
            yield RecordedMessage(self._channels[number], 0, at, at, data)
        elif kind == _CONNECTION:
            self._add_channel(fields, data)
        elif kind == _HEADER and fields.get(b"encryptor"):
            raise MalformedMessage("it is encrypted, which is not supported")
        self._indexed = self._indexed or kind == _CHUNK_INFO

    def _add_channel(self, fields: _Fields, data: bytes) -> None:
        described = _fields_of(data)
        topic, name = (
            _field(given, key).decode("utf-8", "replace") for given, key in ((fields, b"topic"), (described, b"type"))
        )
        text = described.get(b"message_definition", b"")
        self._channels[_whole(fields, b"conn")] = RecordedChannel(topic, "ros1", name, "ros1msg", text, {})

    def _records(self, stream: IO[bytes]) -> Iterator[tuple[int, _Fields, bytes]]:
        """Yield kinds, headers and contents of records until the stream ends; of a chunk, what there is."""
        while (head := self._block(stream, MOST_HEADER)) is not None:
            if not head:  # zeros, where nothing was written
                self.cut = True
                return
            fields = _fields_of(head)
            kind = _field(fields, b"op", 1)[0]
            data = self._block(stream, MOST_DATA, partly=kind == _CHUNK)
            if data is None:
                self.cut = True
                return
            yield kind, fields, data

    def _block(self, stream: IO[bytes], most: int, *, partly: bool = False) -> bytes | None:
        """Return bytes that follow their number; None if the stream ends before or, unless wanted in part, within."""
        size = stream.read(_SIZE.size)
        if len(size) < _SIZE.size:
            self.cut = self.cut or bool(size)
            return None
        (length,) = _SIZE.unpack(size)
        if length > most:
            raise MessageTooLarge(f"a record of {length} bytes; at most {most} are read")
        data = stream.read(length)
        if len(data) < length:
            self.cut = True
            return data if partly else None
        return data


def _fields_of(data: bytes) -> _Fields:
    """Return the fields of a header, ``name=value`` after their lengths.

    Raises
    ------
    MalformedMessage
        It is none.
    """
    fields, place = {}, 0
    while place + _SIZE.size <= len(data):
        (length,) = _SIZE.unpack_from(data, place)
        name, equals, value = data[place + _SIZE.size : place + _SIZE.size + length].partition(b"=")
        place += _SIZE.size + length
        if not equals or place > len(data):
            raise MalformedMessage("the header of a record is damaged")
        fields[name] = value
    return fields


def _field(fields: _Fields, name: bytes, size: int | None = None) -> bytes:
    value = fields.get(name)
    if value is None or (size is not None and len(value) != size):
        raise MalformedMessage(f"a record has no field {name.decode()}: the bag is damaged")
    return value


def _whole(fields: _Fields, name: bytes) -> int:
    return int(_SIZE.unpack(_field(fields, name, _SIZE.size))[0])


def _expanded(fields: _Fields, data: bytes) -> bytes:
    """Return the content of a chunk, as far as it is there.

    Raises
    ------
    MalformedMessage
        It is damaged, or its compression is unknown.
    MessageTooLarge
        It is larger than `MOST_DATA`.
    """
    compression, size = _field(fields, b"compression"), _whole(fields, b"size")
    if size > MOST_DATA:
        raise MessageTooLarge(f"a chunk of {size} bytes; at most {MOST_DATA} are read")
    expand = _EXPANDERS.get(compression)
    if expand is None:
        raise MalformedMessage(f"unknown compression {compression[:32]!r} of a chunk; known: none, bz2, lz4")
    return expand(data, size)


def _bz2(data: bytes, most: int) -> bytes:
    try:
        return bz2.BZ2Decompressor().decompress(data, max_length=most)
    except (OSError, EOFError) as error:
        raise MalformedMessage(f"a chunk cannot be decompressed: {error}") from error


_EXPANDERS: dict[bytes, Callable[[bytes, int], bytes]] = {
    b"none": lambda data, _: data,
    b"bz2": _bz2,
    b"lz4": expand_lz4,
}
