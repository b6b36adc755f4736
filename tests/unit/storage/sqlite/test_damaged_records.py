"""A record that cannot be read affects no other record.

The kind is "damaged records". Its members: heads of maps (``tests/unit/storage/files/test_log_entries.py``), files of
maps (by their hash), users, tokens and robots in lists, plans in the outbox.
"""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import robot, token, user


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
    assert "a stored User cannot be read" in caplog.text
    with pytest.raises(Unavailable, match="restore it from a backup"):
        store.user("ann")


def test_a_damaged_token_or_robot_hides_no_other(store: SqliteStore, tmp_path: Path) -> None:
    for number in ("1", "2"):
        store.add_token(token(64 * number))
        store.put_robot(robot(f"tb{number}"))
    damage(tmp_path, "tokens", "hash", 64 * "1")
    damage(tmp_path, "robots", "id", "tb1")
    assert [one.hash for one in store.tokens("ann", limit=1)] == [64 * "2"]
    assert [one.id for one in store.robots("ann")] == ["tb2"]


def test_a_damaged_user_can_be_removed(store: SqliteStore, tmp_path: Path) -> None:
    damage(tmp_path, "users", "id", "ann")
    store.remove_user("ann")
    store.add_user(user("ann"))
    assert store.user("ann") == user("ann")
