"""A bag of ROS, of any format, also SQLite (``.db3``) and cut off: its messages, and what could not be read."""

import shutil
import sqlite3
import struct
from collections import Counter
from collections.abc import Container, Iterator
from contextlib import closing, contextmanager
from io import BufferedReader
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Final

from ppaas.errors import InvalidInput, MalformedMessage
from ppaas.recording.reader import MAGIC as MCAP_MAGIC
from ppaas.recording.reader import McapReader, RecordedChannel, RecordedMessage, expand_zstd
from ppaas.recording.ros1_bags import MAGIC as ROS1_MAGIC
from ppaas.recording.ros1_bags import OLD_MAGIC, Ros1BagReader
from ppaas.wire.ros.types import MAX_MESSAGE
from robots.recordings.files import UncompressedFile, files_of

SQLITE_MAGIC: Final = b"SQLite format 3\x00"

# -- reads bags of ROS 2 in SQLite (``.db3``), also those that are cut off ---------------------------------------------

_HEADER = struct.Struct(">16xH10xI")
"""Size of a page, and number of pages, in the header of a database."""

_COUNT_AT: Final = 28
"""Place of the number of pages."""

_ERRORS = (sqlite3.Error, UnicodeDecodeError, ValueError, TypeError)
"""Errors of damaged databases: Python cannot decode some texts of SQLite's."""

_LOG: Final = "-wal"
"""End of the name of the write-ahead log beside a database, which has what was not yet moved into it."""


class SqliteReader:
    """Reader of one database.

    Parameters
    ----------
    path : Path
        It is not changed, and no file is made beside it.

    Attributes
    ----------
    cut : bool
        Whether the database ends before its end, as far as read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.cut = False

    def messages(self) -> Iterator[RecordedMessage]:
        """Yield the messages in the order of recording.

        Raises
        ------
        MalformedMessage
            It is not a bag of ROS 2.
        """
        log = self._path.with_name(self._path.name + _LOG)
        pages = _missing_pages(self._path)
        self.cut = pages is not None
        if not (self.cut or (log.is_file() and log.stat().st_size)):
            yield from self._read(f"{self._path.absolute().as_uri()}?mode=ro&immutable=1")
            return
        with TemporaryDirectory() as folder:
            copied = Path(folder, self._path.name)
            shutil.copyfile(self._path, copied)
            if pages is not None:
                _set_pages(copied, *pages)
            elif log.is_file():
                shutil.copyfile(log, copied.with_name(log.name))
            yield from self._read(copied.as_uri())

    def _read(self, uri: str) -> Iterator[RecordedMessage]:
        with closing(sqlite3.connect(uri, uri=True)) as database:
            database.text_factory = lambda text: text.decode("utf-8", "replace")
            try:
                channels = _channels(database)
                rows = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id")
            except _ERRORS as error:
                raise MalformedMessage(f"it is a database, but no bag of ROS 2: {error}") from error
            while row := self._next(rows):
                topic, at, data = row
                if topic in channels and isinstance(at, int) and isinstance(data, bytes):
                    yield RecordedMessage(channels[topic], 0, at, at, data)

    def _next(self, rows: sqlite3.Cursor) -> tuple[int, int, bytes] | None:
        try:
            row: tuple[int, int, bytes] | None = rows.fetchone()
        except _ERRORS:  # pages are missing
            self.cut = True
            return None
        return row


def _missing_pages(path: Path) -> tuple[int, int] | None:
    """Return the size and the number of the pages of a database that is shorter than it says; None if it is whole.

    Source: https://www.sqlite.org/fileformat.html, 1.3.
    """
    with path.open("rb") as file:
        header = file.read(_HEADER.size)
        if len(header) < _HEADER.size:
            return None
        size, count = _HEADER.unpack(header)
        size = 65536 if size == 1 else size
        there = path.stat().st_size // max(1, size)
    return (size, there) if there < count else None


def _set_pages(path: Path, size: int, count: int) -> None:
    """Shorten a database to whole pages, and let its header say so: SQLite reads missing pages as zeros otherwise."""
    with path.open("r+b") as file:
        file.truncate(size * count)
        file.seek(_COUNT_AT)
        file.write(count.to_bytes(4, "big"))


def _channels(database: sqlite3.Connection) -> dict[int, RecordedChannel]:
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    texts: dict[str, tuple[str, str]] = {}
    if "message_definitions" in tables:
        rows = database.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")
        texts = {kind: (encoding, text) for kind, encoding, text in rows}
    topics = database.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
    return {number: _channel(name, kind, form, *texts.get(kind, ("", ""))) for number, name, kind, form in topics}


def _channel(topic: str, kind: str, form: str, encoding: str, text: str) -> RecordedChannel:
    return RecordedChannel(str(topic), str(form), str(kind), str(encoding), str(text).encode(), {})


# -- a bag of ROS, of any format ---------------------------------------------------------------------------------------

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

    def messages(self) -> Iterator[RecordedMessage]:
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

    def _of_file(self, path: Path) -> Iterator[RecordedMessage]:
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
    ) -> Iterator[RecordedMessage]:
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
