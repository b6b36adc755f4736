"""Everything in a store is read, and what is damaged is named."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import Unavailable
from ppaas.geometry import poses_along
from storage.files.store import FileMapStore
from storage.memory.store import MemoryStore
from storage.migration.damage import damaged_of, read_map_store, read_store
from storage.sqlite.store import SqliteStore
from tests.support.storage.full_store import fill, fill_maps
from tests.support.storage.records import plan


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the file of a store with all kinds of records."""
    store = SqliteStore(tmp_path / "store.db")
    fill(store, plans=5, robots=3)
    steps = np.random.default_rng(1).integers(-1, 2, (200, 2))
    walk = poses_along(np.cumsum(steps, axis=0) * 0.05, 0.0).tobytes()
    store.add_plans([plan("walk", poses=walk, version="v9"), plan("again", poses=walk, version="v9")])
    store.close()
    return tmp_path / "store.db"


@pytest.fixture
def changed(file: Path) -> Iterator[sqlite3.Connection]:
    with closing(sqlite3.connect(file, isolation_level=None)) as connection:
        yield connection


def faults(file: Path) -> list[str]:
    with closing(SqliteStore(file)) as store:
        return damaged_of(list(read_store(store)))


def flip(connection: sqlite3.Connection, table: str, column: str, at: int) -> None:
    """Flip a byte of the first row of a table."""
    row, data = connection.execute(f"SELECT rowid, {column} FROM {table} LIMIT 1").fetchone()
    at %= len(data)
    flipped = data[:at] + bytes((data[at] ^ 0x55,)) + data[at + 1 :]
    connection.execute(f"UPDATE {table} SET {column} = ? WHERE rowid = ?", (flipped, row))


def test_nothing_is_damaged_in_a_whole_store(file: Path) -> None:
    with closing(SqliteStore(file)) as store:
        found = {one.kind: (one.records, one.damaged) for one in read_store(store)}
    assert {
        "users",
        "tokens",
        "robots",
        "clones",
        "people",
        "tasks",
        "buildings",
        "webhooks",
        "webhook_deliveries",
        "links",
        "plans",
        "file",
    } <= found.keys()
    assert all(records and not damaged for records, damaged in found.values()), found
    assert found["plans"][0] == 7


@pytest.mark.parametrize(
    "table",
    ["users", "tokens", "robots", "clones", "people", "tasks", "buildings", "webhooks", "webhook_deliveries", "links"],
)
@pytest.mark.parametrize("at", [0, 12, -1])
def test_a_damaged_record_is_named_alone(file: Path, changed: sqlite3.Connection, table: str, at: int) -> None:
    flip(changed, table, "record", at)
    [fault] = faults(file)
    assert fault.startswith(f"{table}/")
    assert "is damaged" in fault
    assert fault.endswith("restore it from a backup")


def test_a_damaged_segment_of_plans_is_named(file: Path, changed: sqlite3.Connection) -> None:
    flip(changed, "chunks", "data", -1)
    assert any(fault.startswith("chunks/") for fault in faults(file))


def test_a_plan_whose_segment_is_missing_fails_alone(file: Path, changed: sqlite3.Connection) -> None:
    changed.execute("DELETE FROM chunks")
    found = faults(file)
    assert any(fault.startswith("plans/walk: ") and "a segment is missing" in fault for fault in found)
    with closing(SqliteStore(file)) as store:
        with pytest.raises(Unavailable, match="a segment is missing"):
            store.plan("walk")
        assert len(store.plans("house")) >= 2


def test_a_store_in_memory_is_read(file: Path) -> None:
    store = MemoryStore()
    fill(store, plans=2, robots=3)
    assert damaged_of(list(read_store(store))) == []


def test_damaged_maps_are_named_and_the_others_read(tmp_path: Path) -> None:
    store = FileMapStore(tmp_path / "maps")
    fill_maps(store)
    [whole] = read_map_store(store)
    assert (whole.records, whole.damaged) == (2, [])
    largest = max((tmp_path / "maps" / "house").glob("files-*/*"), key=lambda path: path.stat().st_size)
    data = bytearray(largest.read_bytes())
    data[-1] ^= 1
    largest.chmod(0o600)
    largest.write_bytes(data)
    [damaged] = read_map_store(FileMapStore(tmp_path / "maps"))
    assert len(damaged.damaged) == 1
    assert "house" in damaged.damaged[0]
    entry = max((tmp_path / "maps" / "alone" / "log").iterdir(), key=lambda path: int(path.name))
    entry.write_bytes(entry.read_bytes().replace(b"ann", b"bnn"))
    [both] = read_map_store(FileMapStore(tmp_path / "maps"))
    assert (both.records, len(both.damaged)) == (2, 2)
