"""Reads bags of ROS 2 in SQLite (``.db3``), also those that are cut off."""

import shutil
import sqlite3
import struct
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from ppaas.errors import MalformedMessage
from ppaas.recording.reader import Channel, Message

MAGIC: Final = b"SQLite format 3\x00"

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

    def messages(self) -> Iterator[Message]:
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

    def _read(self, uri: str) -> Iterator[Message]:
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
                    yield Message(channels[topic], 0, at, at, data)

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


def _channels(database: sqlite3.Connection) -> dict[int, Channel]:
    tables = {name for (name,) in database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    texts: dict[str, tuple[str, str]] = {}
    if "message_definitions" in tables:
        rows = database.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions")
        texts = {kind: (encoding, text) for kind, encoding, text in rows}
    topics = database.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
    return {number: _channel(name, kind, form, *texts.get(kind, ("", ""))) for number, name, kind, form in topics}


def _channel(topic: str, kind: str, form: str, encoding: str, text: str) -> Channel:
    return Channel(str(topic), str(form), str(kind), str(encoding), str(text).encode(), {})
