"""Writes and copies MCAP files of messages: CDR with definitions of ROS 2, so that tools of others open them.

Source: the specification of MCAP (https://mcap.dev/spec), and its registry of profiles (``ros2``).
"""

from collections.abc import Callable, Iterable
from typing import IO, Any, NamedTuple

import msgspec

from ppaas.errors import InvalidInput
from ppaas.recording.batches import About, BatchedMessage
from ppaas.recording.mcap_library import mcap_modules
from ppaas.recording.reader import McapReader, RecordedChannel, RecordedMessage
from ppaas.wire.names import ros2_type
from ppaas.wire.ros.own_types import types_with

# -- writing -----------------------------------------------------------------------------------------------------------

PROFILE = "ros2"
CHUNK = 256 << 10
"""Size at which messages are compressed and written [bytes]."""

ABOUT, ROBOT_FILE, PARAMETERS = "ppaas", "robot.json", "parameters.json"
"""Names of the metadata and of the attachments by which a replay sets up the clone."""

DIRECTION, UP, DOWN = "ppaas_direction", "up", "down"
"""Metadata of a channel: whether its messages came from outside or from the clone."""

_FOREVER = "sec: 9223372036\n    nsec: 854775807"
_QOS = """- history: 1
  depth: {depth}
  reliability: 1
  durability: {durability}
  deadline:
    {forever}
  lifespan:
    {forever}
  liveliness: 1
  liveliness_lease_duration:
    {forever}
  avoid_ros_namespace_conventions: false"""
"""QoS of a topic, as ``ros2 bag`` stores it: keep last, reliable."""

_VOLATILE, _TRANSIENT_LOCAL = 2, 1


class Encoded(NamedTuple):
    """A recorded message as CDR."""

    entry: BatchedMessage
    data: bytes


def encoded(entry: BatchedMessage) -> Encoded:
    """Return a message as CDR.

    Raises
    ------
    UnknownType
        Its type is unknown.
    MalformedMessage
        It is not a message of its type.
    """
    return Encoded(entry, types_with(entry.type).encode_json(entry.type, entry.payload))


class McapFile:
    """An MCAP file that is being written. The caller opens and closes the stream.

    Parameters
    ----------
    stream : binary stream
        Opened for writing; it can tell its position.
    about : About
        Robot, map and parameters of the recording.
    """

    def __init__(self, stream: IO[bytes], about: About) -> None:
        writer, _ = mcap_modules()
        self._stream = stream
        self._writer: Any = writer.Writer(stream, chunk_size=CHUNK)
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str, bool], int] = {}
        self._sequences: dict[int, int] = {}
        self._writer.start(profile=PROFILE, library=f"ppaas {about.software}")
        self._writer.add_metadata(ABOUT, _texts(about))
        for name, content in ((ROBOT_FILE, about.file), (PARAMETERS, about.parameters)):
            self._writer.add_attachment(0, 0, name, "application/json", msgspec.json.encode(content))

    @property
    def size(self) -> int:
        """Number of bytes written; messages since the last chunk are not among them."""
        return self._stream.tell()

    def add(self, message: Encoded, *, log_time: int | None = None) -> None:
        """Add a message; ``log_time`` replaces its time of arrival, for one that is repeated at the begin of a file.

        Such a message has the sequence number 0.
        """
        entry = message.entry
        channel = self._channel(entry)
        if log_time is None:
            sequence = self._sequences[channel] = self._sequences.get(channel, 0) + 1
        else:
            sequence = 0
        self._writer.add_message(
            channel, entry.log_time if log_time is None else log_time, message.data, entry.publish_time, sequence
        )

    def _channel(self, entry: BatchedMessage) -> int:
        key = entry.topic, entry.type, entry.up
        if key not in self._channels:
            latched = {"depth": 1, "durability": _TRANSIENT_LOCAL}
            qos = _QOS.format(
                **(latched if entry.latched else {"depth": 10, "durability": _VOLATILE}), forever=_FOREVER
            )
            notes = {"offered_qos_profiles": qos, DIRECTION: UP if entry.up else DOWN}
            self._channels[key] = self._writer.register_channel(
                f"/{entry.topic}", "cdr", self._schema(entry.type), notes
            )
        return self._channels[key]

    def _schema(self, name: str) -> int:
        if name not in self._schemas:
            text = types_with(name).definition(name).encode()
            self._schemas[name] = self._writer.register_schema(ros2_type(name, "msg"), "ros2msg", text)
        return self._schemas[name]

    def flush(self) -> None:
        """Write what was added, so that it is in the file whatever happens to this process."""
        self._writer.flush()

    def finish(self) -> None:
        """Write the index and the end of the file."""
        self._writer.finish()
        self._stream.flush()


def _texts(about: About) -> dict[str, str]:
    return {
        "robot": about.robot,
        "software": about.software,
        "map": about.map,
        "map_version": about.map_version,
    }


# -- copies: files that were cut off, segments of a ring, some topics --------------------------------------------------


class CopiedMessages(NamedTuple):
    """Numbers of what was copied: messages, and files that were cut off or damaged at their end."""

    messages: int
    incomplete: int


class McapCopy:
    """A new file, of the messages of others. The caller opens and closes the stream.

    Parameters
    ----------
    stream : binary stream
        Opened for writing; it can tell its position.
    permits : callable
        Returns whether a topic is copied, by its name without a leading slash.
    """

    def __init__(self, stream: IO[bytes], permits: Callable[[str], bool]) -> None:
        writer, _ = mcap_modules()
        self._writer: Any = writer.Writer(stream, chunk_size=CHUNK)
        self._permits = permits
        self._schemas: dict[tuple[str, str, bytes], int] = {}
        self._channels: dict[tuple[object, ...], int] = {}
        self._messages = self._incomplete = 0
        self._sources = 0

    def copy(self, sources: Iterable[IO[bytes]]) -> CopiedMessages:
        """Copy files one after the other, and finish the new one.

        Metadata and attachments come from the first. Messages that the later ones repeat at their begin (sequence
        number 0) are left out. A damaged file is copied as far as it is good.
        """
        for source in sources:
            self._copy(source)
        if not self._sources:
            self._writer.start(profile=PROFILE)
        self._writer.finish()
        return CopiedMessages(self._messages, self._incomplete)

    def _copy(self, source: IO[bytes]) -> None:
        try:
            reader, begun = McapReader(source), False
            for message in reader.messages():
                if not begun:
                    begun = True
                    self._begin(reader)
                if (message.sequence or self._sources == 1) and self._permits(message.channel.topic.lstrip("/")):
                    self._add(message)
            self._incomplete += reader.cut
        except InvalidInput:
            self._incomplete += 1

    def _begin(self, reader: McapReader) -> None:
        """Begin with the messages of a file; the first one gives the new file its metadata."""
        self._sources += 1
        if self._sources > 1:
            return
        self._writer.start(profile=reader.profile, library=reader.library)
        for name, texts in reader.metadata.items():
            self._writer.add_metadata(name, texts)
        for name, data in reader.attachments.items():
            self._writer.add_attachment(0, 0, name, "application/json", data)

    def _add(self, message: RecordedMessage) -> None:
        self._messages += 1
        self._writer.add_message(
            self._channel(message.channel), message.log_time, message.data, message.publish_time, message.sequence
        )

    def _channel(self, channel: RecordedChannel) -> int:
        key = (*channel[:-1], *sorted(channel.metadata.items()))
        if key not in self._channels:
            self._channels[key] = self._writer.register_channel(
                channel.topic, channel.encoding, self._schema(channel), channel.metadata
            )
        return self._channels[key]

    def _schema(self, channel: RecordedChannel) -> int:
        if not channel.type:
            return 0
        key = channel.type, channel.schema_encoding, channel.definition
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(*key)
        return self._schemas[key]
