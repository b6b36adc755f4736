"""Copies messages of MCAP files into one that is complete: files that were cut off, segments of a ring, some topics."""

from collections.abc import Callable, Iterable
from typing import IO, Any, NamedTuple

from ppaas.errors import InvalidInput
from ppaas.recording.mcap_library import mcap_modules
from ppaas.recording.reader import Channel, McapReader, Message
from ppaas.recording.writer import CHUNK, PROFILE


class Copied(NamedTuple):
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

    def copy(self, sources: Iterable[IO[bytes]]) -> Copied:
        """Copy files one after the other, and finish the new one.

        Metadata and attachments come from the first. Messages that the later ones repeat at their begin (sequence
        number 0) are left out. A damaged file is copied as far as it is good.
        """
        for source in sources:
            self._copy(source)
        if not self._sources:
            self._writer.start(profile=PROFILE)
        self._writer.finish()
        return Copied(self._messages, self._incomplete)

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

    def _add(self, message: Message) -> None:
        self._messages += 1
        self._writer.add_message(
            self._channel(message.channel), message.log_time, message.data, message.publish_time, message.sequence
        )

    def _channel(self, channel: Channel) -> int:
        key = (*channel[:-1], *sorted(channel.metadata.items()))
        if key not in self._channels:
            self._channels[key] = self._writer.register_channel(
                channel.topic, channel.encoding, self._schema(channel), channel.metadata
            )
        return self._channels[key]

    def _schema(self, channel: Channel) -> int:
        if not channel.type:
            return 0
        key = channel.type, channel.schema_encoding, channel.definition
        if key not in self._schemas:
            self._schemas[key] = self._writer.register_schema(*key)
        return self._schemas[key]
