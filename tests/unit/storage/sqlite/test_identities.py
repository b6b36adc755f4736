"""Index of users by identity in SQLite: of files of earlier releases, of their writes, and on a full disk."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from ppaas.errors import NotFound
from storage.encoding import encode
from storage.sharing_records import ProvidedIdentity
from storage.sqlite import identities
from storage.sqlite.connections import MIGRATIONS
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import user

ANN, BOB = (ProvidedIdentity("https://login.example", name) for name in ("id of ann", "id of bob"))
BEFORE = next(number for number, step in enumerate(MIGRATIONS) if any("unindexed" in str(one) for one in step))
"""Version of the schema before the index."""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "store.db"


@pytest.fixture
def raw(path: Path) -> Iterator[sqlite3.Connection]:
    """Return a connection to a store with ann, whose look-ups are indexed."""
    with closing(SqliteStore(path)) as store:
        store.add_user(user("ann", identity=ANN))
        assert store.user_with_identity(ANN).id == "ann"
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        yield connection


def unindexed(connection: sqlite3.Connection) -> list[str]:
    return [name for (name,) in connection.execute("SELECT user FROM unindexed_users ORDER BY user")]


def test_users_of_a_file_without_the_index_are_found(path: Path, raw: sqlite3.Connection) -> None:
    for trigger in ("users_added", "users_changed"):
        raw.execute(f"DROP TRIGGER {trigger}")
    for table in ("identities", "unindexed_users"):
        raw.execute(f"DROP TABLE {table}")
    raw.execute(f"PRAGMA user_version = {BEFORE}")
    with closing(SqliteStore(path)) as store:
        assert unindexed(raw) == ["ann"]
        assert store.user_with_identity(ANN) == user("ann", identity=ANN)
        assert unindexed(raw) == []
        assert store.user_with_identity(ANN).id == "ann"


def test_what_an_earlier_release_writes_is_found(path: Path, raw: sqlite3.Connection) -> None:
    raw.execute("INSERT INTO users VALUES ('bob', ?)", (encode(user("bob", identity=BOB)),))
    raw.execute("UPDATE users SET record = ? WHERE id = 'ann'", (encode(user("ann")),))
    with closing(SqliteStore(path)) as store:
        assert store.user_with_identity(BOB).id == "bob"
        with pytest.raises(NotFound):
            store.user_with_identity(ANN)
        assert unindexed(raw) == []


def test_a_look_up_reads_the_user_alone(path: Path, raw: sqlite3.Connection) -> None:
    plan = " ".join(row[3] for row in raw.execute(f"EXPLAIN QUERY PLAN {identities._READ}", ("a", "b")))
    assert "SCAN users" not in plan.replace("SCAN users_", "") and "SEARCH users" in plan


def test_a_look_up_works_while_nothing_can_be_written(path: Path, raw: sqlite3.Connection) -> None:
    raw.execute("INSERT INTO users VALUES ('bob', ?)", (encode(user("bob", identity=BOB)),))
    with closing(SqliteStore(path, busy_timeout=0.01)) as store:
        raw.execute("BEGIN IMMEDIATE")
        assert store.user_with_identity(BOB).id == "bob"
        assert store.user_with_identity(ANN).id == "ann"
        raw.execute("ROLLBACK")
        assert unindexed(raw) == ["bob"]


def test_a_damaged_user_hides_no_other(path: Path, raw: sqlite3.Connection) -> None:
    raw.execute("INSERT INTO users VALUES ('abe', x'00')")
    with closing(SqliteStore(path)) as store:
        assert store.user_with_identity(ANN).id == "ann"
        assert unindexed(raw) == []
