"""The SQLite store beyond the contract of stores: durability, sharing between processes, and error messages."""

import contextlib
import os
import sqlite3
import stat
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import Unavailable
from ppaas.tasks.records import Task
from storage.people import MapPeople
from storage.records import MapTask
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


CHECKSUM = 9
"""Size of a checksum with its mark [bytes]."""


@pytest.fixture
def three_users(tmp_path: Path) -> Iterator[SqliteStore]:
    opened = SqliteStore(tmp_path / "three_users.sqlite")
    for name in ("ann", "bob", "eve"):
        opened.add_user(user(name))
    yield opened
    opened.close()


def damage(tmp_path: Path, table: str, key: str, value: str) -> None:
    with closing(sqlite3.connect(tmp_path / "three_users.sqlite", isolation_level=None)) as connection:
        connection.execute(f"UPDATE {table} SET record = x'00' WHERE {key} = ?", (value,))


# A record that cannot be read affects no other record.
#
# The kind is "damaged records". Its members: heads of maps (``tests/unit/storage/files/test_map_log.py``), files
# of maps (by their hash), users, tokens and robots in lists, plans in the outbox.


def test_a_damaged_user_hides_no_other(
    three_users: SqliteStore, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    damage(tmp_path, "users", "id", "ann")
    assert [one.id for one in three_users.users()] == ["bob", "eve"]
    assert [one.id for one in three_users.users(limit=1)] == ["bob"]
    assert [one.id for one in three_users.users(after="bob", limit=5)] == ["eve"]
    assert "users/ann is damaged" in caplog.text
    with pytest.raises(Unavailable, match=r"users/ann is damaged.*restore it from a backup"):
        three_users.user("ann")


def test_a_damaged_token_or_robot_hides_no_other(three_users: SqliteStore, tmp_path: Path) -> None:
    for number in ("1", "2"):
        three_users.add_token(token(64 * number))
        three_users.put_robot(robot(f"tb{number}"))
    damage(tmp_path, "tokens", "hash", 64 * "1")
    damage(tmp_path, "robots", "id", "tb1")
    assert [one.hash for one in three_users.tokens("ann", limit=1)] == [64 * "2"]
    assert [one.id for one in three_users.robots("ann")] == ["tb2"]


def test_a_flipped_byte_is_found_wherever_it_is(three_users: SqliteStore, tmp_path: Path) -> None:
    three_users.put_task(MapTask("ann", "house", Task(id="t1", kind="go_to", places=((1.0, 2.0, 0.0),))))
    three_users.put_robot(robot("tb1"))
    three_users.save_clone(clone("tb1"))
    three_users.put_people_settings(MapPeople("ann", "house"))
    reads: dict[str, tuple[str, Callable[[], object]]] = {
        "users": ("users/ann", lambda: three_users.user("ann")),
        "robots": ("robots/ann/tb1", lambda: three_users.robot("ann", "tb1")),
        "clones": ("clones/ann/tb1", lambda: three_users.clone("ann", "tb1")),
        "people": ("people/house/ann", lambda: three_users.map_people("ann", "house")),
        "tasks": ("tasks/ann/house/t1", lambda: three_users.task("ann", "house", "t1")),
    }
    for table, (place, read) in reads.items():
        whole = read()
        with closing(sqlite3.connect(tmp_path / "three_users.sqlite", isolation_level=None)) as connection:
            query = f"SELECT rowid, record FROM {table} LIMIT 1"
            row, record = connection.execute(query).fetchone()
            for at in range(len(record)):
                flipped = record[:at] + bytes((record[at] ^ 0x55,)) + record[at + 1 :]
                connection.execute(f"UPDATE {table} SET record = ? WHERE rowid = ?", (flipped, row))
                if at < len(record) - CHECKSUM or at >= len(record) - 4:
                    with pytest.raises(Unavailable, match=f"{place} is damaged"):
                        read()
                else:
                    with contextlib.suppress(Unavailable):
                        assert read() == whole, "only the mark of the checksum is damaged"


def test_a_damaged_user_can_be_removed(three_users: SqliteStore, tmp_path: Path) -> None:
    damage(tmp_path, "users", "id", "ann")
    three_users.remove_user("ann")
    three_users.add_user(user("ann"))
    assert three_users.user("ann") == user("ann")
