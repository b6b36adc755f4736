"""A bag of ROS, of any format: its messages, and what of it could not be read."""

import shutil
from collections import Counter
from collections.abc import Container, Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO

from ppaas.errors import InvalidInput
from ppaas.recording.reader import MAGIC as MCAP_MAGIC
from ppaas.recording.reader import McapReader, Message, expand_zstd
from ppaas.recording.ros1_bags import MAGIC as ROS1_MAGIC
from ppaas.recording.ros1_bags import OLD_MAGIC, Ros1BagReader
from ppaas.wire.ros.types import MAX_MESSAGE
from robots.recordings.bags.files import files_of
from robots.recordings.bags.sqlite_file import MAGIC as SQLITE_MAGIC
from robots.recordings.bags.sqlite_file import SqliteReader
from robots.recordings.bags.uncompressed import UncompressedFile

ROS_ENCODINGS = ("cdr", "ros1")
"""Encodings of the messages of ROS 2 and ROS 1."""

_ZSTD = b"\x28\xb5\x2f\xfd"
"""First bytes of a message that ``ros2 bag`` compressed by itself; CDR begins with a zero."""

_MAGIC = (MCAP_MAGIC, ROS1_MAGIC, SQLITE_MAGIC, OLD_MAGIC)
_LONGEST = max(map(len, _MAGIC))


def is_bag_file(path: Path) -> bool:
    """Return whether a file begins as a bag does, compressed or not; False if it cannot be read."""
    try:
        with UncompressedFile(path) as file:
            return (file.read(_LONGEST) or b"").startswith(_MAGIC)
    except InvalidInput:
        return False


def _is_blank(path: Path) -> bool:
    """Return whether a file has no content but zeros and a part of the first bytes of a bag."""
    with UncompressedFile(path) as file:
        head = file.read(_LONGEST) or b""
    return not any(head) or any(magic.startswith(head) and magic != head for magic in _MAGIC)


def messages(count: int) -> str:
    """Return a number of messages in words."""
    return f"{count} {'message' if count == 1 else 'messages'}"


class Bag:
    """A bag of ROS 1 or 2: a file, perhaps compressed, or a folder of files.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    attachments : dict of str to bytes
        Attachments of MCAP files by name, as far as read.
    topics : Counter of tuple
        Number of messages by topic, type and encoding, as far as read.
    cut : list of Path
        Files that were found to end before their end.

    Raises
    ------
    InvalidInput
        There is no such file, or the folder has no bag.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._files = files_of(path)
        self.attachments: dict[str, bytes] = {}
        self.topics: Counter[tuple[str, str, str]] = Counter()
        self.cut: list[Path] = []

    def messages(self) -> Iterator[Message]:
        """Yield the messages of all files, in the order of recording; a file that is cut off is read up to the cut.

        Of several files, one without content counts as cut off, since a recorder may have just opened it.

        Raises
        ------
        InvalidInput
            A file cannot be read, is damaged, or is no bag.
        """
        self.topics.clear()
        self.cut.clear()
        for path in self._files.paths:
            if len(self._files.paths) > 1 and _is_blank(path):
                self.cut.append(path)
                continue
            try:
                for message in self._of_file(path):
                    channel = message.channel
                    self.topics[channel.topic, channel.type, channel.encoding] += 1
                    yield message
            except InvalidInput as error:
                text = str(error)
                raise (
                    error if text.startswith("cannot read") else type(error)(f"cannot read the bag {path}: {text}")
                ) from error

    def notes(self, encodings: Container[str] = ROS_ENCODINGS) -> list[str]:
        """Return what was left out, as far as read: ends that are cut off, and messages in other encodings."""
        notes = [*self._files.notes]
        notes += [f"{path} is cut off, and was read up to the cut" for path in self.cut]
        notes += [
            f"{messages(count)} on {topic} left out: {encoding[:32] or 'none'!r} is no encoding that is read"
            for (topic, _, encoding), count in sorted(self.topics.items())
            if encoding not in encodings
        ]
        return notes

    def contents(self) -> str:
        """Return the topics with their types and numbers of messages, and what was left out, as far as read."""
        texts = [
            f"{topic} ({kind or encoding}, {count})" for (topic, kind, encoding), count in sorted(self.topics.items())
        ]
        return "; ".join((", ".join(texts) or "none", *self.notes()))

    # -- files ---------------------------------------------------------------------------------------------------------

    def _of_file(self, path: Path) -> Iterator[Message]:
        with UncompressedFile(path) as file, BufferedReader(file) as stream:
            magic = stream.peek(_LONGEST)[:_LONGEST]
            if magic.startswith(SQLITE_MAGIC):
                with _on_disk(path, stream, compressed=file.compressed) as database:
                    yield from self._of_reader(SqliteReader(database), path, file)
                return
            if not magic:
                raise InvalidInput("its compressed content is damaged" if file.compressed else "it is empty")
            if not magic.startswith(_MAGIC):
                raise InvalidInput("it is no bag: its first bytes are those of no MCAP file, database or bag of ROS 1")
            reader = McapReader(stream) if magic.startswith(MCAP_MAGIC) else Ros1BagReader(stream)
            yield from self._of_reader(reader, path, file)
            if isinstance(reader, McapReader):
                self.attachments = reader.attachments | self.attachments

    def _of_reader(
        self, reader: McapReader | Ros1BagReader | SqliteReader, path: Path, file: UncompressedFile
    ) -> Iterator[Message]:
        for message in reader.messages():
            packed = message.channel.encoding == "cdr" and message.data.startswith(_ZSTD)
            yield message._replace(data=expand_zstd(message.data, MAX_MESSAGE)) if packed else message
        if reader.cut or file.cut:
            self.cut.append(path)


@contextmanager
def _on_disk(path: Path, stream: IO[bytes], *, compressed: bool) -> Iterator[Path]:
    """Provide a file that is not compressed: the file itself, or one in a temporary folder."""
    if not compressed:
        yield path
        return
    with TemporaryDirectory() as folder:
        copied = Path(folder, "bag.db3")
        with copied.open("wb") as out:
            shutil.copyfileobj(stream, out, 1 << 20)
        yield copied
