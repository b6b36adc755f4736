"""A plan that cannot be read affects no other plan, and is named."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import NotFound, Unavailable
from storage.migration.damage import damaged_of, read_store
from storage.plan_query import PlanStoreQuery
from storage.sqlite.connections import MIGRATIONS
from storage.sqlite.plan_schema import add_plan_checksums
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import plan
from tests.unit.storage.sqlite.test_plans import path

POSES = np.random.default_rng(1).normal(size=(3, 100, 7))
NAMES = ("a", "b", "c")


def record(number: int):
    return plan(NAMES[number], poses=POSES[number].tobytes())


@pytest.fixture
def file(tmp_path: Path) -> Iterator[sqlite3.Connection]:
    """Return a connection to the file of three plans, of which the second is to be damaged."""
    with closing(SqliteStore(tmp_path / "store.sqlite")) as store:
        store.add_plans(map(record, range(3)))
    with closing(sqlite3.connect(tmp_path / "store.sqlite", isolation_level=None)) as connection:
        yield connection


def damage(file: sqlite3.Connection, column: str, at: int, mask: int = 0x55) -> bytes:
    """Flip bits of one byte of the second plan; return the column as it was."""
    [(whole,)] = file.execute(f"SELECT {column} FROM plans WHERE sequence = 2").fetchall()
    flipped = bytearray(whole)
    flipped[at] ^= mask
    file.execute(f"UPDATE plans SET {column} = ? WHERE sequence = 2", (bytes(flipped),))
    return bytes(whole)


@pytest.mark.parametrize("column", ["body", "recipe"])
def test_a_flipped_byte_of_a_plan_is_found_and_spoils_that_plan_alone(
    file: sqlite3.Connection, column: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    [(size,)] = file.execute(f"SELECT length({column}) FROM plans WHERE sequence = 2").fetchall()
    with closing(SqliteStore(tmp_path / "store.sqlite")) as store:
        for at in range(0, size, max(1, size // 40)):
            whole = damage(file, column, at)
            assert sorted(head.id for head in store.plans("house")) == ["a", "c"], at
            assert sorted(store.whole_plans(NAMES)) == ["a", "c"], at
            assert store.plan("a") == record(0)
            with pytest.raises(Unavailable, match=r"plans/2 is damaged \(.*\): restore it from a backup"):
                store.plan("b")
            assert any("plans/2 is damaged" in fault for fault in damaged_of(list(read_store(store))))
            file.execute(f"UPDATE plans SET {column} = ? WHERE sequence = 2", (whole,))
        assert store.plan("b") == record(1)
        assert damaged_of(list(read_store(store))) == []
    assert "plans/2 is damaged" in caplog.text


def test_plans_are_added_counted_and_removed_beside_a_damaged_one(file: sqlite3.Connection, tmp_path: Path) -> None:
    damage(file, "body", 0, 0x0F)
    with closing(SqliteStore(tmp_path / "store.sqlite")) as store:
        store.add_plan(plan("d"))
        assert store.plan_statistics("house").plans == 3
        store.remove_plan("a")
        assert sorted(head.id for head in store.plans("house")) == ["c", "d"]
        store.remove_plan("b")
        with pytest.raises(NotFound):
            store.plan("b")
        assert damaged_of(list(read_store(store))) == []


def test_a_damaged_plan_can_be_added_again(file: sqlite3.Connection, tmp_path: Path) -> None:
    damage(file, "body", 20)
    with closing(SqliteStore(tmp_path / "store.sqlite")) as store:
        assert store.add_plans([record(1)]) == 1
        assert store.plan("b") == record(1)
        assert sorted(head.id for head in store.plans("house")) == ["a", "b", "c"]


def test_all_plans_of_a_map_are_removed_although_one_is_damaged(file: sqlite3.Connection, tmp_path: Path) -> None:
    damage(file, "body", 0, 0x0F)
    with closing(SqliteStore(tmp_path / "store.sqlite")) as store:
        assert store.remove_plans("house") == 3
        assert store.plans("house") == [] and store.plan_maps() == []


def test_plans_of_a_release_without_checksums_are_read(file: sqlite3.Connection, tmp_path: Path) -> None:
    file.execute("ALTER TABLE plans DROP COLUMN crc")
    file.execute(f"PRAGMA user_version = {MIGRATIONS.index((add_plan_checksums,))}")
    damage(file, "body", 0, 0x0F)
    with closing(SqliteStore(tmp_path / "store.sqlite")) as store:
        assert store.plan("a") == record(0)
        assert sorted(head.id for head in store.plans("house")) == ["a", "c"]
        store.add_plan(plan("d"))
        assert store.plan("d").id == "d"
        assert any("plans/2" in fault for fault in damaged_of(list(read_store(store))))


class TestSegments:
    """Segments that plans share: two of the three plans go the same way, the third one another."""

    @pytest.fixture
    def store(self, tmp_path: Path) -> Iterator[SqliteStore]:
        with closing(SqliteStore(tmp_path / "ways.sqlite")) as opened:
            opened.add_plans([path("a", 0.0), path("b", 0.0), path("c", 5.0)])
            yield opened

    @pytest.fixture
    def ways(self, store: SqliteStore, tmp_path: Path) -> Iterator[sqlite3.Connection]:
        """Return a connection to a file in which the first segment of the first two plans has a flipped bit."""
        with closing(sqlite3.connect(tmp_path / "ways.sqlite", isolation_level=None)) as connection:
            [(number, data)] = connection.execute("SELECT id, data FROM chunks ORDER BY id LIMIT 1").fetchall()
            connection.execute(
                "UPDATE chunks SET data = ? WHERE id = ?", (data[:-1] + bytes([data[-1] ^ 0x10]), number)
            )
            yield connection

    @pytest.mark.usefixtures("ways")
    def test_a_flipped_bit_spoils_the_plans_that_have_it_alone(
        self, store: SqliteStore, caplog: pytest.LogCaptureFixture
    ) -> None:
        assert sorted(store.whole_plans(NAMES)) == ["c"]
        assert "plans/1 is damaged" in caplog.text
        search = PlanStoreQuery("house", "v1", (0.0, 5.0), (9.95, 5.0), 0.5)
        assert [passage.head.id for passage in store.plans_through(search)] == ["c"]
        for name in ("a", "b"):
            with pytest.raises(Unavailable, match="a segment is missing or damaged"):
                store.plan(name)

    @pytest.mark.usefixtures("ways")
    def test_a_passage_is_not_found_in_a_damaged_segment(self, store: SqliteStore) -> None:
        assert store.plans_through(PlanStoreQuery("house", "v1", (0.0, 0.0), (9.95, 0.0), 0.5)) == []

    @pytest.mark.usefixtures("ways")
    def test_it_is_written_again_with_a_new_plan_of_that_way(self, tmp_path: Path) -> None:
        with closing(SqliteStore(tmp_path / "ways.sqlite")) as restarted:
            restarted.add_plan(path("d", 0.0))
            assert sorted(restarted.whole_plans((*NAMES, "d"))) == ["a", "b", "c", "d"]
            assert damaged_of(list(read_store(restarted))) == []

    @pytest.mark.usefixtures("ways")
    def test_a_check_of_the_store_names_it_and_its_plans(self, store: SqliteStore) -> None:
        found = damaged_of(list(read_store(store)))
        assert [fault.partition(" ")[0] for fault in found] == ["plans/b:", "plans/a:", "chunks/1"]

    def test_plans_that_have_it_are_removed_with_it(self, store: SqliteStore, ways: sqlite3.Connection) -> None:
        assert store.remove_plans("house") == 3
        for table in ("chunks", "chunk_refs", "chunk_ids", "chunk_places", "plans"):
            assert ways.execute(f"SELECT count(*) FROM {table}").fetchone() == (0,), table

    def test_segments_of_a_release_without_checksums_are_read(
        self, store: SqliteStore, ways: sqlite3.Connection
    ) -> None:
        ways.execute("UPDATE chunks SET crc = NULL")
        assert store.plan("c").id == "c"
        ways.execute("UPDATE chunks SET data = x'00' WHERE id = 1")
        assert sorted(store.whole_plans(NAMES)) == ["c"]

    def test_a_damaged_sample_of_plans_hides_no_passage(self, store: SqliteStore, ways: sqlite3.Connection) -> None:
        ways.execute("UPDATE chunks SET plans = x'010203'")
        search = PlanStoreQuery("house", "v1", (0.0, 5.0), (9.95, 5.0), 0.5)
        assert [passage.head.id for passage in store.plans_through(search)] == ["c"]
