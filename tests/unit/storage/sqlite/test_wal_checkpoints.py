"""The WAL is checkpointed in the background, without blocking commits."""

import shutil
import sqlite3
import threading
from collections.abc import Iterator
from contextlib import closing
from functools import partial
from pathlib import Path

import pytest

from storage.sqlite import wal_checkpoints
from storage.sqlite.store import SqliteStore
from storage.sqlite.wal_checkpoints import CHANGED_ROWS, WalCheckpointer
from tests.support.storage.records import user
from tests.support.waiting import wait_until


@pytest.fixture
def writer(tmp_path: Path) -> Iterator[sqlite3.Connection]:
    """Return a connection that runs no automatic checkpoints."""
    with closing(sqlite3.connect(tmp_path / "some.db", isolation_level=None)) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        connection.execute("PRAGMA wal_autocheckpoint = 0")
        connection.execute("CREATE TABLE numbers (number INTEGER)")
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        connection.execute("INSERT INTO numbers VALUES (7)")
        yield connection


def rows_in_the_file(path: Path) -> int:
    """Return the number of rows in a file without its WAL."""
    alone = shutil.copy(path, path.with_name("alone.db"))
    with closing(sqlite3.connect(alone)) as connection:
        return int(connection.execute("SELECT count(*) FROM numbers").fetchone()[0])


def test_commits_are_checkpointed_once_there_are_many(writer: sqlite3.Connection, tmp_path: Path) -> None:
    path = tmp_path / "some.db"
    with closing(WalCheckpointer(partial(sqlite3.connect, path))) as checkpoints:
        checkpoints.committed(CHANGED_ROWS - 1)
        assert checkpoints._thread is None
        checkpoints.committed(1)
        wait_until(lambda: rows_in_the_file(path) == 1)
        writer.execute("INSERT INTO numbers VALUES (8)")
        checkpoints.committed(CHANGED_ROWS)
        wait_until(lambda: rows_in_the_file(path) == 2)
        thread = checkpoints._thread
    assert thread is not None and not thread.is_alive()
    checkpoints.committed(CHANGED_ROWS)


def test_a_checkpoint_does_not_wait_for_readers_and_writers(writer: sqlite3.Connection, tmp_path: Path) -> None:
    path = tmp_path / "some.db"
    with (
        closing(sqlite3.connect(path, isolation_level=None)) as reader,
        closing(WalCheckpointer(partial(sqlite3.connect, path))) as checkpoints,
    ):
        reader.execute("BEGIN")
        assert reader.execute("SELECT count(*) FROM numbers").fetchone() == (1,)
        writer.execute("BEGIN IMMEDIATE")
        writer.execute("INSERT INTO numbers VALUES (8)")
        checkpoints.committed(CHANGED_ROWS)
        wait_until(lambda: rows_in_the_file(path) == 1)
        writer.execute("COMMIT")
        assert reader.execute("SELECT count(*) FROM numbers").fetchone() == (1,)


def test_a_failed_checkpoint_is_logged_and_tried_again(
    writer: sqlite3.Connection, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path, full = tmp_path / "some.db", threading.Event()

    def connect() -> sqlite3.Connection:
        if not full.is_set():
            full.set()
            raise sqlite3.OperationalError("disk I/O error")
        return sqlite3.connect(path)

    with closing(WalCheckpointer(connect)) as checkpoints:
        checkpoints.committed(CHANGED_ROWS)
        wait_until(lambda: "disk I/O error" in caplog.text)
        assert rows_in_the_file(path) == 0
        checkpoints.committed(CHANGED_ROWS)
        wait_until(lambda: rows_in_the_file(path) == 1)


def test_a_store_checkpoints_its_commits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wal_checkpoints, "CHANGED_ROWS", 3)
    path = tmp_path / "store.db"
    with closing(SqliteStore(path)) as store:
        before = path.stat().st_size
        for name in ("ann", "bob", "cid"):
            store.add_user(user(name))
        wait_until(lambda: path.stat().st_size > before or b"cid" in path.read_bytes())
