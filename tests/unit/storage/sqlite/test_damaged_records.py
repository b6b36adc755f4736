"""A record that cannot be read affects no other record.

The kind is "damaged records". Its members: heads of maps (``tests/unit/storage/files/test_log_entries.py``), files of
maps (by their hash), users, tokens and robots in lists, plans in the outbox.
"""

import contextlib
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from ppaas.tasks.records import Task
from storage.people_records import MapPeople
from storage.records import MapTask
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import clone, robot, token, user

CHECKSUM = 9
"""Size of a checksum with its mark [bytes]."""


@pytest.fixture
def store(tmp_path: Path) -> Iterator[SqliteStore]:
    opened = SqliteStore(tmp_path / "store.sqlite")
    for name in ("ann", "bob", "eve"):
        opened.add_user(user(name))
    yield opened
    opened.close()


def damage(tmp_path: Path, table: str, key: str, value: str) -> None:
    with closing(sqlite3.connect(tmp_path / "store.sqlite", isolation_level=None)) as connection:
        connection.execute(f"UPDATE {table} SET record = x'00' WHERE {key} = ?", (value,))


def test_a_damaged_user_hides_no_other(store: SqliteStore, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    damage(tmp_path, "users", "id", "ann")
    assert [one.id for one in store.users()] == ["bob", "eve"]
    assert [one.id for one in store.users(limit=1)] == ["bob"]
    assert [one.id for one in store.users(after="bob", limit=5)] == ["eve"]
    assert "users/ann is damaged" in caplog.text
    with pytest.raises(Unavailable, match=r"users/ann is damaged.*restore it from a backup"):
        store.user("ann")


def test_a_damaged_token_or_robot_hides_no_other(store: SqliteStore, tmp_path: Path) -> None:
    for number in ("1", "2"):
        store.add_token(token(64 * number))
        store.put_robot(robot(f"tb{number}"))
    damage(tmp_path, "tokens", "hash", 64 * "1")
    damage(tmp_path, "robots", "id", "tb1")
    assert [one.hash for one in store.tokens("ann", limit=1)] == [64 * "2"]
    assert [one.id for one in store.robots("ann")] == ["tb2"]


def test_a_flipped_byte_is_found_wherever_it_is(store: SqliteStore, tmp_path: Path) -> None:
    store.put_task(MapTask("ann", "house", Task(id="t1", kind="go_to", places=((1.0, 2.0, 0.0),))))
    store.put_robot(robot("tb1"))
    store.save_clone(clone("tb1"))
    store.put_people_settings(MapPeople("ann", "house"))
    reads: dict[str, tuple[str, Callable[[], object]]] = {
        "users": ("users/ann", lambda: store.user("ann")),
        "robots": ("robots/ann/tb1", lambda: store.robot("ann", "tb1")),
        "clones": ("clones/ann/tb1", lambda: store.clone("ann", "tb1")),
        "people": ("people/house/ann", lambda: store.map_people("ann", "house")),
        "tasks": ("tasks/ann/house/t1", lambda: store.task("ann", "house", "t1")),
    }
    for table, (place, read) in reads.items():
        whole = read()
        with closing(sqlite3.connect(tmp_path / "store.sqlite", isolation_level=None)) as connection:
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


def test_a_damaged_user_can_be_removed(store: SqliteStore, tmp_path: Path) -> None:
    damage(tmp_path, "users", "id", "ann")
    store.remove_user("ann")
    store.add_user(user("ann"))
    assert store.user("ann") == user("ann")
