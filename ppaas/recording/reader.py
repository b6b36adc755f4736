"""Reads MCAP files, also those that are cut off, damaged or hostile, in bounded memory, and decodes their messages.

The records are classes of the library ``mcap``; their framing is read here, because a file that was not finished has no
index and no end, and lengths in a file are not to be believed. Source: the specification of MCAP
(https://mcap.dev/spec).
"""

import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from io import BytesIO
from typing import IO, Any, NamedTuple

from ppaas.errors import MalformedMessage, MessageTooLarge, UnknownType
from ppaas.recording.mcap_library import mcap_modules
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.own_types import types_with

# -- reading of files that may be cut off, damaged or hostile ----------------------------------------------------------

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, ATTACHMENT, METADATA = 1, 2, 3, 4, 5, 6, 9, 12
"""Opcodes of the records that are read."""

UNWRITTEN = 0
"""No opcode: zeros, where a computer lost its power before the content was written."""

MOST_RECORD = 64 << 20
"""Largest record that is read [bytes]; attachments that are larger are skipped."""

MOST_CHUNK = 64 << 20
"""Largest chunk after decompression [bytes]."""

MOST_CHANNELS = 4096
"""Largest number of channels, and of schemas."""

MOST_NOTES = 16 << 20
"""Largest size of all metadata, attachments and schemas that are kept [bytes]."""

_FRAME = struct.Struct("<BQ")


class RecordedChannel(NamedTuple):
    """A topic of a file: its encoding, the name, encoding and text of its type, and its metadata."""

    topic: str
    encoding: str
    type: str
    schema_encoding: str
    definition: bytes
    metadata: dict[str, str]


class RecordedMessage(NamedTuple):
    """A message of a file; times are in ns since the epoch."""

    channel: RecordedChannel
    sequence: int
    log_time: int
    publish_time: int
    data: bytes


class McapReader:
    """Reader of one file.

    Parameters
    ----------
    stream : binary stream
        Opened for reading, at its begin.

    Attributes
    ----------
    profile, library : str
        Profile of the file, and the program that wrote it.
    metadata : dict
        Metadata by name, as far as read.
    attachments : dict of str to bytes
        Attachments by name, as far as read.
    cut : bool
        Whether the file ends before its end: it was not finished, or is damaged there.

    Raises
    ------
    MalformedMessage
        It is not an MCAP file.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        _, self._records = mcap_modules()
        self._stream = stream
        self._schemas: dict[int, Any] = {}
        self._channels: dict[int, RecordedChannel] = {}
        self._noted = 0
        self.profile = self.library = ""
        self.metadata: dict[str, dict[str, str]] = {}
        self.attachments: dict[str, bytes] = {}
        self.cut = False
        if stream.read(len(MAGIC)) != MAGIC:
            raise MalformedMessage("not an MCAP file: its first bytes are others")

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield the messages: within a chunk by time, and chunks in the order of the file.

        Raises
        ------
        MalformedMessage
            A record is damaged: its checksum is wrong, or it contradicts itself.
        MessageTooLarge
            A record, a chunk or the number of channels exceeds its limit.
        """
        for opcode, data in self._framed(self._stream):
            if opcode == FOOTER:
                return
            if opcode == CHUNK:
                yield from self._chunk(self._parsed("Chunk", data))
            elif (message := self._take(opcode, data)) is not None:
                yield message
        self.cut = True

    # -- records -------------------------------------------------------------------------------------------------------

    def _framed(self, stream: IO[bytes]) -> Iterator[tuple[int, bytes]]:
        """Yield opcodes and contents of records until the stream ends, perhaps within one."""
        while len(head := stream.read(_FRAME.size)) == _FRAME.size:
            opcode, length = _FRAME.unpack(head)
            if opcode == UNWRITTEN:
                return
            if length > MOST_RECORD:
                if opcode != ATTACHMENT:
                    raise MessageTooLarge(f"a record of {length} bytes; at most {MOST_RECORD} are read")
                if not _skip(stream, length):
                    return
                continue
            data = stream.read(length)
            if len(data) < length:
                return
            yield opcode, data

    def _take(self, opcode: int, data: bytes) -> RecordedMessage | None:
        """Note what a record says; return it if it is a message."""
        if opcode == MESSAGE:
            return self._message(data)
        if opcode == SCHEMA:
            self._note(data)
            schema = self._parsed("Schema", data)
            self._schemas[schema.id] = schema
        elif opcode == CHANNEL:
            self._note(data)
            self._add_channel(self._parsed("Channel", data))
        elif opcode == HEADER:
            header = self._parsed("Header", data)
            self.profile, self.library = header.profile[:256], header.library[:256]
        elif opcode == METADATA:
            self._note(data)
            found = self._parsed("Metadata", data)
            self.metadata[found.name] = found.metadata
        elif opcode == ATTACHMENT:
            self._attach(data)
        return None

    def _attach(self, data: bytes) -> None:
        if self._noted + len(data) <= MOST_NOTES:
            self._note(data)
            found = self._parsed("Attachment", data)
            self.attachments[found.name] = found.data

    def _note(self, data: bytes) -> None:
        self._noted += len(data)
        if self._noted > MOST_NOTES or max(len(self._schemas), len(self._channels)) >= MOST_CHANNELS:
            raise MessageTooLarge(
                f"more than {MOST_CHANNELS} channels, or {MOST_NOTES >> 20} MiB of their types and of metadata"
            )

    def _add_channel(self, channel: Any) -> None:
        schema = self._schemas.get(channel.schema_id)
        if schema is None and channel.schema_id:
            raise MalformedMessage(f"channel {channel.topic[:64]!r} names schema {channel.schema_id}, which is missing")
        name, encoding, text = ("", "", b"") if schema is None else (schema.name, schema.encoding, schema.data)
        self._channels[channel.id] = RecordedChannel(
            channel.topic, channel.message_encoding, name, encoding, text, channel.metadata
        )

    def _message(self, data: bytes) -> RecordedMessage:
        if len(data) < _MESSAGE.size:
            raise MalformedMessage(f"a message of {len(data)} bytes has no header")
        number, sequence, log_time, publish_time = _MESSAGE.unpack_from(data)
        if number not in self._channels:
            raise MalformedMessage(f"a message names channel {number}, which is missing")
        return RecordedMessage(self._channels[number], sequence, log_time, publish_time, data[_MESSAGE.size :])

    def _parsed(self, kind: str, data: bytes) -> Any:
        from mcap.data_stream import ReadDataStream  # noqa: PLC0415 - as in `mcap_modules`
        from mcap.exceptions import McapError  # noqa: PLC0415

        try:
            return getattr(self._records, kind).read(ReadDataStream(BytesIO(data)))
        except (McapError, struct.error, ValueError, OverflowError) as error:
            raise MalformedMessage(f"a record of kind {kind} is damaged: {error or 'it ends early'}") from error

    # -- chunks --------------------------------------------------------------------------------------------------------

    def _chunk(self, chunk: Any) -> list[RecordedMessage]:
        """Return the messages of a chunk by time; of equal times, in the order of the file."""
        data = _decompressed(chunk)
        if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
            raise MalformedMessage("the checksum of a chunk is wrong: the file is damaged")
        taken = (self._take(opcode, record) for opcode, record in self._framed(BytesIO(data)))
        return sorted((message for message in taken if message is not None), key=lambda message: message.log_time)


_MESSAGE = struct.Struct("<HIQQ")


def _skip(stream: IO[bytes], length: int) -> bool:
    """Read and drop bytes; return whether there were so many."""
    while length > 0:
        block = stream.read(min(length, 1 << 20))
        if not block:
            return False
        length -= len(block)
    return True


def _decompressed(chunk: Any) -> bytes:
    """Return the content of a chunk, which says its size itself.

    Raises
    ------
    MessageTooLarge
        It is larger than `MOST_CHUNK`, whatever its header says.
    MalformedMessage
        The compression is unknown, or the content is damaged.
    """
    if chunk.uncompressed_size > MOST_CHUNK:
        raise MessageTooLarge(f"a chunk of {chunk.uncompressed_size} bytes; at most {MOST_CHUNK} are read")
    expand = _EXPANDERS.get(chunk.compression)
    if expand is None:
        raise MalformedMessage(f"unknown compression {chunk.compression[:32]!r} of a chunk; known: zstd, lz4, none")
    data: bytes = expand(chunk.data, chunk.uncompressed_size + 1)
    if len(data) != chunk.uncompressed_size:
        raise MalformedMessage(f"a chunk has {len(data)} bytes or more, and not {chunk.uncompressed_size}")
    return data


def expand_zstd(data: bytes, most: int) -> bytes:
    """Decompress at most some bytes, in memory of that size: frames may name any size of their content."""
    import zstandard  # noqa: PLC0415 - of the extra recording, as mcap

    expanding = zstandard.ZstdDecompressor(max_window_size=MOST_CHUNK)
    try:
        return bytes(expanding.stream_reader(BytesIO(data), read_across_frames=True).read(most))
    except zstandard.ZstdError as error:
        raise MalformedMessage(f"a chunk cannot be decompressed: {error}") from error


def expand_lz4(data: bytes, most: int) -> bytes:
    """Decompress at most some bytes."""
    import lz4.frame  # noqa: PLC0415 - likewise

    try:
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=most))
    except (RuntimeError, EOFError) as error:
        raise MalformedMessage(f"a chunk cannot be decompressed: {error}") from error


_EXPANDERS = {"": lambda data, most: data[:most], "zstd": expand_zstd, "lz4": expand_lz4}


# -- messages of MCAP files as JSON of rosbridge -----------------------------------------------------------------------

MOST_SKIPPED = 256
"""Largest number of topics whose skipped messages are counted."""

_OF_OLD_ROBOTS = {"tf/tfMessage": "tf2_msgs/TFMessage"}
"""Types of early ROS 1, and today's types with the same fields."""


class McapDecoder:
    """Decoder of the messages of one file.

    Attributes
    ----------
    skipped : Counter of str
        Number of messages that could not be decoded, by topic and reason.
    """

    def __init__(self) -> None:
        self.skipped: Counter[str] = Counter()

    def json(self, message: RecordedMessage) -> bytes | None:
        """Return a message as JSON; None if its type is unknown or it is not one of its type, which is counted."""
        try:
            return decoded(message.channel, message.data)
        except (UnknownType, MalformedMessage) as error:
            self.skip(message, str(error))
            return None

    def skip(self, message: RecordedMessage, why: str) -> None:
        """Count a message that cannot be used."""
        reason = f"{message.channel.topic[:64]}: {why[:200]}"
        if reason in self.skipped or len(self.skipped) < MOST_SKIPPED:
            self.skipped[reason] += 1


def decoded(channel: RecordedChannel, data: bytes) -> bytes:
    """Return a message of a channel as JSON.

    Raises
    ------
    UnknownType
        Its encoding or its type is unknown.
    MalformedMessage
        It is not a message of its type.
    """
    match channel.encoding:
        case "cdr":
            return types_with(channel.type).decode_json(channel.type, data)
        case "ros1":
            return ros_types("noetic").decode_json(_OF_OLD_ROBOTS.get(channel.type, channel.type), data)
        case "json":
            return data
    raise UnknownType(f"unknown encoding {channel.encoding[:32]!r}; known: cdr, ros1, json")
