"""Connections to one SQLite file: opened as threads need them, kept for the next, closed together.

The file is in WAL mode, so that readers and the one writer do not wait for each other, and every commit is synced,
unless its caller says that it need not be: what was acknowledged is on the disk.
"""

import fcntl
import os
import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

from ppaas.errors import Unavailable
from storage.disk_errors import disk_errors
from storage.sqlite.plan_schema import BEFORE_PLAN_TABLES, PLAN_TABLES, renew_plans
from storage.sqlite.plan_writes import move_plans
from storage.sqlite.wal_checkpoints import Checkpoints

APPLICATION_ID = 0x50506153  # "PPaS": tells our files from other programs'

CHECKPOINT_PAGES = 6144
"""Pages of 4 KiB in the WAL from which whoever commits brings them to the file, where that was not done beside
(``storage.sqlite.wal_checkpoints``) or was not done with. Then the WAL is written over from its beginning, and what is
written over is synced several times as fast as what makes a file grow."""

CACHE_KIB = 16384
"""What a connection may hold of the file in memory."""

Migration = str | Callable[[sqlite3.Connection], None]

MIGRATIONS: tuple[tuple[Migration, ...], ...] = (
    (
        "CREATE TABLE users (id TEXT PRIMARY KEY, record BLOB NOT NULL) STRICT",
        """CREATE TABLE tokens (hash TEXT PRIMARY KEY, user TEXT NOT NULL REFERENCES users ON DELETE CASCADE,
           expires REAL NOT NULL, record BLOB NOT NULL) STRICT""",
        "CREATE INDEX tokens_by_user ON tokens (user)",
        "CREATE INDEX tokens_by_expiry ON tokens (expires)",
        """CREATE TABLE robots (user TEXT NOT NULL, id TEXT NOT NULL, record BLOB NOT NULL,
           PRIMARY KEY (user, id)) STRICT""",
        """CREATE TABLE plans (sequence INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE, map TEXT NOT NULL,
           created REAL NOT NULL, record BLOB NOT NULL) STRICT""",
        "CREATE INDEX plans_by_map ON plans (map, created DESC, sequence DESC)",
        """CREATE TABLE clones (user TEXT NOT NULL, robot TEXT NOT NULL, record BLOB NOT NULL,
           PRIMARY KEY (user, robot)) STRICT""",
    ),
    (
        "DROP INDEX plans_by_map",
        "CREATE INDEX plans_by_map ON plans (map, created DESC, id DESC)",
    ),
    (
        """CREATE TABLE urdfs (user TEXT NOT NULL, robot TEXT NOT NULL, urdf BLOB NOT NULL,
           PRIMARY KEY (user, robot)) STRICT""",
    ),
    (
        """CREATE TABLE history (map TEXT NOT NULL, version TEXT NOT NULL, planner TEXT NOT NULL,
           bucket INTEGER NOT NULL, queries INTEGER NOT NULL, failed INTEGER NOT NULL, computed INTEGER NOT NULL,
           reused INTEGER NOT NULL, stitched INTEGER NOT NULL, micros INTEGER NOT NULL,
           logs INTEGER NOT NULL, squares INTEGER NOT NULL, compared INTEGER NOT NULL,
           millimetres INTEGER NOT NULL, cheapest_millimetres INTEGER NOT NULL,
           PRIMARY KEY (map, version, planner, bucket)) STRICT, WITHOUT ROWID""",
        "CREATE TABLE links (link TEXT PRIMARY KEY, record BLOB NOT NULL) STRICT",
    ),
    (*BEFORE_PLAN_TABLES, *PLAN_TABLES, move_plans),
    (renew_plans,),
)
"""The schema, a version an entry, of statements and functions: entry *n* brings a file from version *n* to *n* + 1, and
is never changed again."""


@dataclass(frozen=True, slots=True)
class Schema:
    """What a kind of file is known by, and how it is made and brought to the present.

    Parameters
    ----------
    application_id : int
        In the head of the file.
    migrations : tuple
        As ``MIGRATIONS``.
    """

    application_id: int
    migrations: tuple[tuple[Migration, ...], ...]


STORE = Schema(APPLICATION_ID, MIGRATIONS)

_ADVICE = {
    sqlite3.SQLITE_BUSY: "locked by another process for too long: try again",
    sqlite3.SQLITE_LOCKED: "locked for too long: try again",
    sqlite3.SQLITE_FULL: "the disk is full: free space",
    sqlite3.SQLITE_CORRUPT: "the file is damaged: restore it from a backup",
    sqlite3.SQLITE_NOTADB: "this is no SQLite file: give another path, or move it away",
    sqlite3.SQLITE_READONLY: "it cannot be written: let the user that runs the cloud write the file and its folder",
    sqlite3.SQLITE_CANTOPEN: "it cannot be opened: let the user that runs the cloud read and write its folder",
    sqlite3.SQLITE_IOERR: "the disk fails or is full: look at its health and its space",
}


class SqliteConnections:
    """A pool of connections to a file, which is made if it is not there.

    Parameters
    ----------
    path : Path
        The file.
    busy_timeout : float
        How long a transaction waits for another process's [s].
    schema : Schema
        What the file is.

    Raises
    ------
    Unavailable
        The file cannot be used; the text says why and what to do.
    """

    def __init__(self, path: Path, busy_timeout: float = 5.0, schema: Schema = STORE) -> None:
        self._path = path
        self._busy_timeout = busy_timeout
        self._schema = schema
        self._lock = threading.Lock()
        self._idle: list[sqlite3.Connection] = []
        self._closed = False
        self._errors = _Errors(path)
        self._checkpoints = Checkpoints(self._connect)
        if path.is_dir():
            raise Unavailable(f"{path}: this is a folder: give the path of a file")
        with disk_errors(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            with _one_at_a_time(path):
                self._prepare()

    @contextmanager
    def reading(self) -> Iterator[sqlite3.Connection]:
        """Lend a connection for a statement that only reads."""
        with self._errors:
            connection = self._take()
            try:
                yield connection
            finally:
                self._give_back(connection)

    @contextmanager
    def reading_at_once(self) -> Iterator[sqlite3.Connection]:
        """Lend a connection for statements that all read the same, whatever is written meanwhile."""
        with self.reading() as connection:
            connection.execute("BEGIN")
            try:
                yield connection
            finally:
                connection.execute("ROLLBACK")

    @contextmanager
    def writing(self, *, synced: bool = True) -> Iterator[sqlite3.Connection]:
        """Lend a connection in a transaction that no other can write beside; an error undoes all of it.

        A commit outlives the process; that it outlives a power cut too, which takes a disk milliseconds, is what
        ``synced`` asks for. Otherwise such may cost the latest commits, though never half of one.
        """
        with self.reading() as connection:
            if not synced:
                connection.execute("PRAGMA synchronous = NORMAL")
            connection.execute("BEGIN IMMEDIATE")
            before = connection.total_changes
            try:
                yield connection
                connection.execute("COMMIT")
                self._checkpoints.committed(connection.total_changes - before)
            finally:
                if connection.in_transaction:
                    connection.execute("ROLLBACK")
                if not synced:
                    connection.execute("PRAGMA synchronous = FULL")

    def close(self) -> None:
        """Close what is idle now, and the rest when it comes back."""
        with self._lock:
            self._closed = True
            idle, self._idle = self._idle, []
        self._checkpoints.close()
        for connection in idle:
            connection.close()

    def _take(self) -> sqlite3.Connection:
        with self._lock:
            if self._closed:
                raise Unavailable(f"{self._path}: the store is closed")
            if self._idle:
                return self._idle.pop()
        return self._connect()

    def _give_back(self, connection: sqlite3.Connection) -> None:
        with self._lock:
            if not self._closed:
                self._idle.append(connection)
                return
        connection.close()

    def _connect(self) -> sqlite3.Connection:
        connection = sqlite3.connect(
            self._path, timeout=self._busy_timeout, isolation_level=None, check_same_thread=False
        )
        try:
            connection.execute("PRAGMA foreign_keys = ON")
            connection.execute("PRAGMA synchronous = FULL")
            connection.execute(f"PRAGMA wal_autocheckpoint = {CHECKPOINT_PAGES}")
            connection.execute(f"PRAGMA cache_size = -{CACHE_KIB}")
        except BaseException:
            connection.close()
            raise
        return connection

    def _prepare(self) -> None:
        """Make the file if it is not there, and bring it to the present schema."""
        if not self._path.exists():
            # Password hashes are kept here: nobody but the owner reads them. SQLite gives its WAL the same mode.
            os.close(os.open(self._path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        with self.reading() as connection:
            self._schema_version(connection)  # what is not ours is not even turned to WAL
            connection.execute("PRAGMA journal_mode = WAL")
        with self.writing() as connection:
            self._migrate(connection)

    def _migrate(self, connection: sqlite3.Connection) -> None:
        version = self._schema_version(connection)
        for statements in self._schema.migrations[version:]:
            for statement in statements:
                if isinstance(statement, str):
                    connection.execute(statement)
                else:
                    statement(connection)
        connection.execute(f"PRAGMA application_id = {self._schema.application_id}")
        connection.execute(f"PRAGMA user_version = {len(self._schema.migrations)}")

    def _schema_version(self, connection: sqlite3.Connection) -> int:
        owner = _number(connection, "PRAGMA application_id")
        if owner == 0 and _number(connection, "SELECT count(*) FROM sqlite_schema") == 0:
            return 0
        if owner != self._schema.application_id:
            raise Unavailable(f"{self._path}: this is another program's database: give another path")
        version = _number(connection, "PRAGMA user_version")
        if version > len(self._schema.migrations):
            raise Unavailable(f"{self._path}: written by a newer release (schema {version}): upgrade this one")
        return version


class _Errors:
    """Tells SQLite's errors as ours. No generator: it is gone through with each plan that is kept."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: object) -> None:
        if isinstance(error, sqlite3.Error):
            primary = getattr(error, "sqlite_errorcode", 0) & 0xFF  # the rest of an extended code is detail
            raise Unavailable(f"{self._path}: {_ADVICE.get(primary, str(error))}") from error


@contextmanager
def _one_at_a_time(path: Path) -> Iterator[None]:
    """Let one process after the other prepare a file: SQLite does not wait while another turns it to WAL."""
    lock = os.open(path.with_name(path.name + ".lock"), os.O_CREAT | os.O_RDWR, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)


def _number(connection: sqlite3.Connection, query: str) -> int:
    with closing(connection.execute(query)) as cursor:
        return int(cursor.fetchone()[0])
