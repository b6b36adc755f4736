"""A pool of connections to one SQLite file.

The file is in WAL mode, so readers and the single writer do not block each other. Every commit is synced to the disk,
unless the caller opts out: acknowledged data is durable.
"""

import fcntl
import os
import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from ppaas.errors import Unavailable
from storage.sqlite.plan_schema import BEFORE_PLAN_TABLES, PLAN_TABLES, add_plan_checksums, move_plans, renew_plans
from storage.sqlite.wal_checkpoints import WalCheckpointer
from storage.store_errors import NO_STORE, disk_errors, unusable

APPLICATION_ID = 0x50506153  # "PPaS": identifies our files

CHECKPOINT_PAGES = 6144
"""Size of the WAL [pages of 4 KiB] at which a commit itself runs a checkpoint, if the background thread
(``storage.sqlite.wal_checkpoints``) has not run one, or has not finished. SQLite then overwrites the WAL from its
beginning; syncing overwritten pages is several times as fast as syncing a growing file."""

CACHE_KIB = 16384
"""Page cache of one connection [KiB]."""

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
    (
        """CREATE TABLE IF NOT EXISTS clone_logs (user TEXT NOT NULL, robot TEXT NOT NULL, log TEXT NOT NULL,
           number INTEGER NOT NULL, data BLOB NOT NULL, PRIMARY KEY (user, robot, log, number)) STRICT""",
    ),
    (
        """CREATE TABLE IF NOT EXISTS people (user TEXT NOT NULL, map TEXT NOT NULL, record BLOB NOT NULL,
           PRIMARY KEY (map, user)) STRICT""",
        """CREATE TABLE IF NOT EXISTS people_counts (user TEXT NOT NULL, map TEXT NOT NULL, hour INTEGER NOT NULL,
           zone TEXT NOT NULL, people INTEGER NOT NULL, PRIMARY KEY (map, user, hour, zone)) STRICT, WITHOUT ROWID""",
    ),
    (
        """CREATE TABLE IF NOT EXISTS robot_shares (grantee TEXT NOT NULL, user TEXT NOT NULL, robot TEXT NOT NULL,
           PRIMARY KEY (grantee, user, robot)) STRICT, WITHOUT ROWID""",
        "CREATE INDEX IF NOT EXISTS robot_shares_by_robot ON robot_shares (user, robot)",
    ),
    (
        """CREATE TABLE IF NOT EXISTS leases (name TEXT PRIMARY KEY, holder TEXT NOT NULL, epoch INTEGER NOT NULL,
           beat INTEGER NOT NULL) STRICT, WITHOUT ROWID""",
    ),
    (
        """CREATE TABLE IF NOT EXISTS tasks (user TEXT NOT NULL, map TEXT NOT NULL, id TEXT NOT NULL,
           record BLOB NOT NULL, PRIMARY KEY (user, map, id)) STRICT""",
    ),
    (add_plan_checksums,),
    (
        """CREATE TABLE IF NOT EXISTS webhooks (user TEXT NOT NULL, id TEXT NOT NULL, record BLOB NOT NULL,
           PRIMARY KEY (user, id)) STRICT""",
        """CREATE TABLE IF NOT EXISTS webhook_deliveries (user TEXT NOT NULL, hook TEXT NOT NULL, id TEXT NOT NULL,
           record BLOB NOT NULL, PRIMARY KEY (user, hook, id)) STRICT""",
    ),
    (
        """CREATE TABLE IF NOT EXISTS identities (issuer TEXT NOT NULL, subject TEXT NOT NULL,
           user TEXT NOT NULL REFERENCES users ON DELETE CASCADE, PRIMARY KEY (issuer, subject, user))
           STRICT, WITHOUT ROWID""",
        "CREATE INDEX IF NOT EXISTS identities_by_user ON identities (user)",
        """CREATE TABLE IF NOT EXISTS unindexed_users (user TEXT PRIMARY KEY REFERENCES users ON DELETE CASCADE)
           STRICT, WITHOUT ROWID""",
        "INSERT OR IGNORE INTO unindexed_users SELECT id FROM users",
        """CREATE TRIGGER IF NOT EXISTS users_added AFTER INSERT ON users
           BEGIN INSERT OR IGNORE INTO unindexed_users VALUES (new.id); END""",
        """CREATE TRIGGER IF NOT EXISTS users_changed AFTER UPDATE OF record ON users
           BEGIN INSERT OR IGNORE INTO unindexed_users VALUES (new.id); END""",
    ),
    (
        """CREATE TABLE IF NOT EXISTS buildings (user TEXT NOT NULL, id TEXT NOT NULL, record BLOB NOT NULL,
           PRIMARY KEY (user, id)) STRICT""",
    ),
)
"""Schema migrations, as SQL statements and functions. Entry *n* migrates a file from version *n* to *n* + 1, and is
never changed after a release."""


@dataclass(frozen=True, slots=True)
class SqliteSchema:
    """Schema of a kind of SQLite file.

    Parameters
    ----------
    application_id : int
        SQLite's ``application_id`` in the file's header.
    migrations : tuple
        Migrations in the form of ``MIGRATIONS``.
    """

    application_id: int
    migrations: tuple[tuple[Migration, ...], ...]


STORE = SqliteSchema(APPLICATION_ID, MIGRATIONS)

_ADVICE = {
    sqlite3.SQLITE_BUSY: "locked by another process for too long: try again",
    sqlite3.SQLITE_LOCKED: "locked for too long: try again",
    sqlite3.SQLITE_FULL: "the disk is full: free space",
    sqlite3.SQLITE_CORRUPT: "the file is damaged: restore it from a backup",
    sqlite3.SQLITE_NOTADB: "not an SQLite file: give another path, or move it away",
    sqlite3.SQLITE_READONLY: "read-only: give the user that runs the cloud write access to the file and its folder",
    sqlite3.SQLITE_CANTOPEN: "cannot be opened: give the user that runs the cloud read and write access to its folder",
    sqlite3.SQLITE_IOERR: "the disk fails or is full: check its health and free space",
}

_PUBLIC = {code: _ADVICE[code] for code in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED, sqlite3.SQLITE_FULL)}
"""Advice that clients may read too."""


class SqliteConnections:
    """A pool of connections to a file, which is created if it is missing. Thread-safe.

    Parameters
    ----------
    path : Path
        The file.
    busy_timeout : float
        Time limit to wait for the transaction of another process [s].
    schema : SqliteSchema
        Schema of the file.

    Raises
    ------
    Unavailable
        The file cannot be used; the message says why and what to do.
    """

    def __init__(self, path: Path, busy_timeout: float = 5.0, schema: SqliteSchema = STORE) -> None:
        self._path = path
        self._busy_timeout = busy_timeout
        self._schema = schema
        self._lock = threading.Lock()
        self._idle: list[sqlite3.Connection] = []
        self._closed = False
        self._errors = _Errors(path)
        self._checkpoints = WalCheckpointer(self._connect)
        if path.is_dir():
            raise unusable(path, "is a folder: give the path of a file")
        with disk_errors(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            with _exclusively(path):
                self._prepare()

    @contextmanager
    def reading(self) -> Iterator[sqlite3.Connection]:
        """Lend a connection for a single statement that only reads."""
        with self._errors:
            connection = self._take()
            try:
                yield connection
            finally:
                self._give_back(connection)

    @contextmanager
    def reading_snapshot(self) -> Iterator[sqlite3.Connection]:
        """Lend a connection in a read transaction: all statements see the same snapshot."""
        with self.reading() as connection:
            connection.execute("BEGIN")
            try:
                yield connection
            finally:
                connection.execute("ROLLBACK")

    @contextmanager
    def writing(self, *, synced: bool = True) -> Iterator[sqlite3.Connection]:
        """Lend a connection in the file's single write transaction; an error rolls it back.

        A commit always survives the end of the process. With ``synced`` it also survives a power failure, which costs
        milliseconds; otherwise a power failure may lose the latest commits, but never a part of one.
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

    def shrink_log(self) -> None:
        """Move the write-ahead log into the file and empty it; does nothing while readers need it or the disk fails."""
        with suppress(Unavailable), self.reading() as connection:
            connection.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()

    def close(self) -> None:
        """Close idle connections now, and the others when they are returned."""
        with self._lock:
            self._closed = True
            idle, self._idle = self._idle, []
        self._checkpoints.close()
        for connection in idle:
            connection.close()

    def _take(self) -> sqlite3.Connection:
        with self._lock:
            if self._closed:
                raise unusable(self._path, "the store is closed")
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
        """Create the file if it is missing, and migrate it to the current schema."""
        if not self._path.exists():
            # Readable by its owner only, because it contains password hashes. SQLite gives its WAL the same mode.
            os.close(os.open(self._path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600))
        with self.reading() as connection:
            self._schema_version(connection)  # refuse a foreign file before it is switched to WAL mode
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
            raise unusable(self._path, "this is the database of another program: give another path")
        version = _number(connection, "PRAGMA user_version")
        if version > len(self._schema.migrations):
            raise unusable(self._path, f"written by a newer release (schema {version}): upgrade this one")
        return version


class _Errors:
    """Context that turns SQLite's errors into ``Unavailable``. A class, because it is faster than a generator."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: object) -> None:
        if isinstance(error, sqlite3.Error):
            primary = getattr(error, "sqlite_errorcode", 0) & 0xFF  # the low byte of an extended code
            raise unusable(self._path, _ADVICE.get(primary, str(error)), _PUBLIC.get(primary, NO_STORE)) from error


@contextmanager
def _exclusively(path: Path) -> Iterator[None]:
    """Lock the preparation of a file: SQLite's busy timeout does not cover the switch to WAL mode."""
    lock = os.open(path.with_name(path.name + ".lock"), os.O_CREAT | os.O_RDWR, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)


def _number(connection: sqlite3.Connection, query: str) -> int:
    with closing(connection.execute(query)) as cursor:
        return int(cursor.fetchone()[0])
