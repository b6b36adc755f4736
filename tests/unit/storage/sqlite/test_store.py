"""The SQLite store beyond the contract of stores: durability, sharing between processes, and error messages."""

import os
import sqlite3
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import Unavailable
from storage.sqlite.connections import MIGRATIONS
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import clone, plan, robot, token, user


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "new" / "store.db"


@pytest.fixture
def store(path: Path) -> Iterator[SqliteStore]:
    with closing(SqliteStore(path)) as opened:
        yield opened


@pytest.fixture
def as_nobody() -> Iterator[Path]:
    """Return a folder that the test can read but not write, also if root runs it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o555)
        if os.geteuid() != 0:
            yield folder
            return
        os.seteuid(65534)
        try:
            yield folder
        finally:
            os.seteuid(0)


def test_a_reopened_file_contains_everything(path: Path) -> None:
    with closing(SqliteStore(path)) as store:
        store.add_user(user("ann"))
        store.add_token(token("a" * 64))
        store.put_robot(robot("tb1", parameters={"x": [1, 2.5]}))
        store.add_plan(plan("p1"))
        store.save_clone(clone("tb1"))
    with closing(SqliteStore(path)) as store:
        assert store.user("ann") == user("ann")
        assert store.token("a" * 64) == token("a" * 64)
        assert store.robot("ann", "tb1") == robot("tb1", parameters={"x": [1, 2.5]})
        assert store.plan("p1") == plan("p1")
        assert store.clone("ann", "tb1") == clone("tb1")


WRITER = """
import sys
from pathlib import Path
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import plan
store = SqliteStore(Path(sys.argv[1]), busy_timeout=60.0)
for number in range(25):
    store.add_plan(plan(f"{sys.argv[2]}-{number}"))
"""


def test_processes_creating_and_writing_the_file_lose_nothing(path: Path) -> None:
    command = [sys.executable, "-c", WRITER, str(path)]
    writers = [subprocess.Popen([*command, f"w{number}"]) for number in range(4)]
    assert [writer.wait() for writer in writers] == [0] * 4
    with closing(SqliteStore(path)) as store:
        kept = {p.id for p in store.plans("house", limit=1000)}
    assert kept == {f"w{writer}-{number}" for writer in range(4) for number in range(25)}


KILLED = """
import os, signal, sys
from pathlib import Path
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import plan, user
store = SqliteStore(Path(sys.argv[1]))
store.add_plan(plan("kept"))
with store._connections.writing() as connection:
    connection.execute("DELETE FROM plans")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_committed_data_survives_a_kill_and_open_transactions_do_not(path: Path) -> None:
    assert subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False).returncode == -9
    with closing(SqliteStore(path)) as store:
        assert store.plan("kept") == plan("kept")


def test_threads_share_a_store(store: SqliteStore) -> None:
    def keep(number: int) -> int:
        store.add_plan(plan(f"p{number}"))
        return len(store.plan(f"p{number}").poses)

    with ThreadPoolExecutor(8) as threads:
        assert set(threads.map(keep, range(80))) == {112}
    assert len(store.plans("house")) == 80


def test_readers_do_not_wait_for_a_writer(store: SqliteStore, path: Path) -> None:
    store.add_user(user("ann"))
    with closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        other.execute("DELETE FROM users")
        assert store.user("ann") == user("ann")


def test_a_file_locked_too_long_by_another_process_is_unavailable(store: SqliteStore, path: Path) -> None:
    with closing(SqliteStore(path, busy_timeout=0.01)) as impatient, closing(sqlite3.connect(path)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(Unavailable, match="locked by another process"):
            impatient.add_user(user("ann"))
        other.rollback()
        impatient.add_user(user("ann"))


def test_an_error_rolls_back_the_whole_transaction(store: SqliteStore) -> None:
    store.put_robot(robot("tb1"))
    with pytest.raises(RuntimeError), store._connections.writing() as connection:
        connection.execute("DELETE FROM robots")
        raise RuntimeError
    assert store.robots("ann") == [robot("tb1")]


def test_a_full_disk_is_unavailable_and_the_store_stays_usable(store: SqliteStore) -> None:
    store.add_plan(plan("small"))
    with store._connections.reading() as connection:
        pages = connection.execute("PRAGMA page_count").fetchone()[0]
        connection.execute(f"PRAGMA max_page_count = {pages}")
    with pytest.raises(Unavailable, match="free space"):
        store.add_plan(plan("large", poses=np.random.default_rng(0).random(7 << 17).tobytes()))
    assert [p.id for p in store.plans("house")] == ["small"]


def test_only_the_owner_may_read_the_files(store: SqliteStore, path: Path) -> None:
    store.add_user(user("ann"))
    modes = {file.name: stat.S_IMODE(file.stat().st_mode) for file in path.parent.iterdir()}
    assert set(modes) == {"store.db", "store.db-wal", "store.db-shm", "store.db.lock"}
    assert set(modes.values()) == {0o600}


def test_calls_to_a_closed_store_are_unavailable(path: Path) -> None:
    store = SqliteStore(path)
    store.close()
    with pytest.raises(Unavailable, match="closed"):
        store.users()


def test_a_folder_that_may_not_be_written_is_unavailable(as_nobody: Path) -> None:
    with pytest.raises(Unavailable, match="permission denied"):
        SqliteStore(as_nobody / "store.db")


def test_a_folder_in_place_of_the_file_is_unavailable(tmp_path: Path) -> None:
    with pytest.raises(Unavailable, match="is a folder"):
        SqliteStore(tmp_path)


def test_a_file_that_is_not_a_database_is_unavailable_and_unchanged(tmp_path: Path) -> None:
    path = tmp_path / "store.db"
    path.write_bytes(b"# my notes, not a database\n" * 100)
    with pytest.raises(Unavailable, match="not an SQLite file"):
        SqliteStore(path)
    assert path.read_bytes() == b"# my notes, not a database\n" * 100


def test_a_damaged_file_is_unavailable(path: Path) -> None:
    with closing(SqliteStore(path)) as store:
        for number in range(50):
            store.add_plan(plan(f"p{number}"))
    data = bytearray(path.read_bytes())
    data[8192:] = b"\xa5" * (len(data) - 8192)
    path.write_bytes(data)
    with pytest.raises(Unavailable, match=r"damaged|backup"), closing(SqliteStore(path)) as store:
        store.plans("house")


def test_a_record_that_cannot_be_read_is_unavailable(store: SqliteStore) -> None:
    store.add_user(user("ann"))
    with store._connections.writing() as connection:
        connection.execute("UPDATE users SET record = x'c1'")
    with pytest.raises(Unavailable, match="users/ann is damaged"):
        store.user("ann")


def test_a_database_of_another_program_is_unchanged(tmp_path: Path) -> None:
    path = tmp_path / "other.db"
    with closing(sqlite3.connect(path)) as other:
        other.execute("CREATE TABLE songs (title)")
    with pytest.raises(Unavailable, match="another program"):
        SqliteStore(path)
    with closing(sqlite3.connect(path)) as other:
        assert other.execute("SELECT name FROM sqlite_schema").fetchall() == [("songs",)]
        assert other.execute("PRAGMA journal_mode").fetchone() == ("delete",)


def test_a_file_of_a_newer_release_is_refused(path: Path) -> None:
    SqliteStore(path).close()
    with closing(sqlite3.connect(path)) as other:
        other.execute(f"PRAGMA user_version = {len(MIGRATIONS) + 1}")
    with pytest.raises(Unavailable, match="newer release"):
        SqliteStore(path)
