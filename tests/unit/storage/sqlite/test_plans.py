"""The path plan database in an SQLite file: concurrent writers, killed writers, and migrations."""

import sqlite3
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ppaas.errors import InvalidInput, Unavailable
from ppaas.geometry import poses_along
from ppaas.plans.encoding.end_buckets import buckets_near
from ppaas.plans.encoding.recipes import read_recipe
from storage.encoding import encode
from storage.plan_query import PlanStoreQuery
from storage.records import PlanRecord
from storage.sqlite import plan_rows
from storage.sqlite.connections import APPLICATION_ID, MIGRATIONS, SqliteConnections, SqliteSchema
from storage.sqlite.plan_counts import MAX_UNCOUNTED
from storage.sqlite.plan_schema import move_plans
from storage.sqlite.plan_writes import MAX_REMEMBERED, IdCache, KnownIds
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import plan


def path(plan_id: str, lane: float = 0.0, count: int = 200, **fields: Any) -> PlanRecord:
    points = np.stack((np.arange(count) * 0.05, np.full(count, lane)), axis=1)
    return plan(plan_id, version="v1", poses=poses_along(points, 0.0).tobytes(), length=count * 0.05, **fields)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "store.db"


def open_one(file: Path, opened: ExitStack) -> SqliteStore:
    return opened.enter_context(closing(SqliteStore(file, busy_timeout=60.0)))


@pytest.fixture
def two(file: Path) -> Iterator[tuple[SqliteStore, SqliteStore]]:
    with ExitStack() as opened:
        yield open_one(file, opened), open_one(file, opened)


def assert_sound(file: Path) -> None:
    """Assert that reference counts are right, and that no reference points to a missing row."""
    with closing(sqlite3.connect(file)) as connection:
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        [counted] = connection.execute("SELECT counted FROM tally").fetchone()
        refs, counted_refs = Counter[int](), Counter[int]()
        for sequence, recipe in connection.execute("SELECT sequence, recipe FROM plans"):
            refs.update(read_recipe(recipe))
            counted_refs.update(read_recipe(recipe) * (sequence <= counted))
        assert dict(connection.execute("SELECT chunk, refs FROM chunk_refs WHERE refs > 0")) == counted_refs
        ids = {row[0] for row in connection.execute("SELECT id FROM chunks")}
        assert ids == set(refs) == {row[0] for row in connection.execute("SELECT chunk FROM chunk_ids")}
        assert {row[0] for row in connection.execute("SELECT chunk FROM chunk_places")} == ids
        plans = {row[0] for row in connection.execute("SELECT sequence FROM plans")}
        for table in ("plan_ids", "plan_spots"):
            assert sorted(row[0] for row in connection.execute(f"SELECT plan FROM {table}")) == sorted(plans)
        counted_plans = sum(sequence <= counted for sequence in plans)
        assert connection.execute("SELECT coalesce(sum(plans), 0) FROM contexts").fetchone() == (counted_plans,)


def test_plans_of_an_earlier_release_are_migrated_and_share_segments(file: Path) -> None:
    earlier = next(number for number, steps in enumerate(MIGRATIONS) if move_plans in steps)
    kept = [path("a"), path("b"), path("c", 1.0)]
    connections = SqliteConnections(file, schema=SqliteSchema(APPLICATION_ID, MIGRATIONS[:earlier]))
    with connections.writing() as connection:
        for record in (*kept, plan("empty", poses=b"")):
            row = (record.id, record.map, record.created, encode(record))
            connection.execute("INSERT INTO plans (id, map, created, record) VALUES (?, ?, ?, ?)", row)
    connections.close()
    with closing(SqliteStore(file)) as store:
        assert [store.plan(record.id) for record in kept] == kept
        statistics = store.plan_statistics()
        assert (statistics.plans, statistics.waypoints) == (3, 600)
        assert statistics.kept < 420
    assert_sound(file)


def test_tables_of_an_unreleased_schema_are_rebuilt(file: Path) -> None:
    with closing(SqliteStore(file)) as store:
        store.add_plan(path("a"))
    with closing(sqlite3.connect(file)) as connection:
        connection.execute("DROP TABLE tally")
        connection.execute("ALTER TABLE plans DROP COLUMN recipe")
        connection.execute("PRAGMA user_version = 5")
    with closing(SqliteStore(file)) as store:
        assert store.plans("house") == []
        store.add_plan(path("a"))
        assert store.plan("a") == path("a")
    assert_sound(file)


def test_removing_the_plans_of_a_map_leaves_no_rows(file: Path) -> None:
    with closing(SqliteStore(file)) as store:
        store.add_plans(path(f"p{number}", number % 3, 150 + number % 7) for number in range(600))
        assert store.remove_plans("house") == 600
        store.add_plan(path("p1"))  # cached ids of removed entries are not used
        assert store.plan("p1") == path("p1")
        assert store.remove_plans("house") == 1
    with closing(sqlite3.connect(file)) as connection:
        tables = [name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        mine = [name for name in tables if name.startswith(("scopes", "contexts", "plan", "chunk"))]
        assert len(mine) == 10
        assert {name: connection.execute(f"SELECT count(*) FROM {name}").fetchone()[0] for name in mine} == (
            dict.fromkeys(mine, 0)
        )
    assert_sound(file)


KILLED = """
import sys
from pathlib import Path
from storage.sqlite.store import SqliteStore
from tests.unit.storage.sqlite.test_plans import path
store = SqliteStore(Path(sys.argv[1]))
for number in range(10**6):
    store.add_plan(path(f"p{number}", number % 7, 200 + number % 5))
    if number % 3 == 2:
        store.remove_plan(f"p{number - 2}")
    print(number, flush=True)
"""


@pytest.mark.parametrize("acknowledged", [1, 20, 77])
def test_acknowledged_plans_survive_a_kill_at_any_time(file: Path, acknowledged: int) -> None:
    command = [sys.executable, "-c", KILLED, str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        for _ in range(acknowledged):
            last = int(writer.stdout.readline())
        writer.kill()
        last = max([last, *map(int, writer.stdout.read().split())])
    with closing(SqliteStore(file)) as store:
        removed = set(range(0, last, 3))  # the last of them perhaps
        for number in range(last + 1):
            if number not in removed:
                assert store.plan(f"p{number}") == path(f"p{number}", number % 7, 200 + number % 5)
        for number in removed - {last - last % 3}:
            assert f"p{number}" not in {record.id for record in store.plans("house")}
    assert_sound(file)


WRITER = """
import sys
from pathlib import Path
from storage.sqlite.store import SqliteStore
from tests.unit.storage.sqlite.test_plans import path
store = SqliteStore(Path(sys.argv[1]), busy_timeout=60.0)
for number in range(40):
    store.add_plan(path(f"{sys.argv[2]}-{number}", number % 3))
    if number % 4 == 3:
        store.remove_plan(f"{sys.argv[2]}-{number - 1}")
"""


def test_processes_writing_the_same_segments_lose_nothing(file: Path) -> None:
    SqliteStore(file).close()
    writers = [subprocess.Popen([sys.executable, "-c", WRITER, str(file), f"w{number}"]) for number in range(3)]
    assert [writer.wait() for writer in writers] == [0, 0, 0]
    with closing(SqliteStore(file)) as store:
        assert len(store.plans("house")) == 90
        assert store.plan("w1-5") == path("w1-5", 2)
    assert_sound(file)


def test_threads_adding_plans_concurrently_store_each_once(file: Path) -> None:
    with ExitStack() as opened, ThreadPoolExecutor(6) as threads:
        store = open_one(file, opened)
        given = [path(f"p{number % 30}", lane=number % 7 * 0.05) for number in range(60)]
        added = list(threads.map(lambda record: store.add_plans([record]), given))
        assert sum(added) == 30
        assert sorted(record.id for record in store.plans(given[0].map, limit=100)) == sorted(
            {each.id for each in given}
        )
    assert_sound(file)


def test_entries_removed_by_another_store_are_written_again(two: tuple[SqliteStore, SqliteStore], file: Path) -> None:
    one, other = two
    one.add_plan(path("a"))
    other.remove_plan("a")
    other.add_plan(path("b", 3.0))
    one.add_plan(path("c"))
    assert one.plan("c") == other.plan("c") == path("c")
    assert_sound(file)


def test_rolled_back_entries_are_not_cached(file: Path) -> None:
    with closing(SqliteStore(file)) as store:
        store.add_plan(path("small"))
        with store._plan_connections.reading() as connection:
            pages = connection.execute("PRAGMA page_count").fetchone()[0]
            connection.execute(f"PRAGMA max_page_count = {pages + 1}")
        noise = np.random.default_rng(1).random((4000, 7)).tobytes()
        with pytest.raises(Unavailable, match="free space"):
            store.add_plans([path("lane", 9.0), plan("noise", poses=noise)])
        with store._plan_connections.reading() as connection:
            connection.execute("PRAGMA max_page_count = 100000")
        store.add_plan(path("other", 5.0))
        store.add_plan(path("lane", 9.0))
        assert (store.plan("lane"), store.plan("other")) == (path("lane", 9.0), path("other", 5.0))
    assert_sound(file)


def test_the_cache_of_entry_ids_is_bounded_and_cleared_by_removals() -> None:
    id_cache = IdCache()
    id_cache.learn(KnownIds({str(number).encode(): number for number in range(MAX_REMEMBERED + 10)}), 3)
    assert b"9" not in id_cache.known(3).chunks
    assert id_cache.known(3).chunks[b"10"] == 10
    assert id_cache.known(4) == KnownIds()
    id_cache.learn(KnownIds({b"new": 1}, {b"robot": (2, 3)}), 4)
    id_cache.learn(KnownIds({b"late": 2}), 3)
    assert id_cache.known(4) == KnownIds({b"new": 1}, {b"robot": (2, 3)})


def test_a_context_is_not_cached_after_its_last_plan_was_removed(
    file: Path, two: tuple[SqliteStore, SqliteStore]
) -> None:
    store, other = two
    short = [plan(name, version="v1", robot="r", poses=path(name, count=3).poses) for name in "abc"]
    store.add_plan(short[0])
    other.remove_plan("a")  # it shares no entry, so only its context is removed
    store.add_plan(short[1])
    assert store.plan("b") == short[1]
    store.replace_plan(short[1], instead_of=short[1])
    store.add_plan(short[2])
    assert [store.plan(each.id) for each in short[1:]] == short[1:]
    assert store.plan_statistics().plans == 2
    assert_sound(file)


def test_concurrent_callers_get_the_number_of_their_own_new_plans(file: Path) -> None:
    with closing(SqliteStore(file)) as store:
        store.add_plan(path("a"))
        given = [[path(name, float(ord(name))) for name in names] for names in ("abc", "", "cd", "dd", "e")]
        assert store._tables._add_all(given) == [2, 0, 1, 0, 1]
        assert store.plan_statistics().plans == 5
    assert_sound(file)


def test_an_invalid_plan_raises_for_its_own_caller_only(file: Path) -> None:
    wrong = [plan("wrong", poses=np.full((4, 7), np.nan).tobytes()), "no plan"]
    with closing(SqliteStore(file)) as store:
        results = store._tables._add_all([[path("a")], [path("b"), wrong[0]], [path("c")], [wrong[1]], [path("d")]])
        assert [one for one in results if isinstance(one, int)] == [1, 1, 1]
        assert [type(results[1]), type(results[3])] == [InvalidInput, AttributeError]
        assert sorted(head.id for head in store.plans("house")) == ["a", "c", "d"]
        with pytest.raises(InvalidInput, match="'wrong'"):
            store.add_plans(wrong[:1])
    assert_sound(file)


def test_statistics_include_plans_not_counted_yet(file: Path) -> None:
    with closing(SqliteStore(file)) as store:
        store.add_plans(path(f"p{number}", created=float(number)) for number in range(MAX_UNCOUNTED))
        for number in range(MAX_UNCOUNTED, MAX_UNCOUNTED + 3):
            store.add_plan(path(f"p{number}", created=float(number)))
        statistics = store.plan_statistics("house")
        assert (statistics.plans, statistics.waypoints) == (MAX_UNCOUNTED + 3, 200 * (MAX_UNCOUNTED + 3))
        assert {part.plans for part in store.plan_parts("p0")[1:-1]} == {MAX_UNCOUNTED + 3}
        assert [head.id for head in store.plans("house", limit=2)] == [
            f"p{MAX_UNCOUNTED + 2}", f"p{MAX_UNCOUNTED + 1}"
        ]  # fmt: skip
        store.add_plan(path("other", 3.0))
        search = PlanStoreQuery("house", "v1", (1.0, 3.0), (5.0, 3.0), 0.1)
        assert [passes.head.id for passes in store.plans_through(search)] == ["other"]
        store.remove_plan("other")
        store.add_plan(path("again", 3.0))
        assert store.plan_statistics("house").plans == MAX_UNCOUNTED + 4
    assert_sound(file)


def test_a_larger_granularity_makes_longer_entries(file: Path) -> None:
    with closing(SqliteStore(file, granularity=64)) as store:
        store.add_plan(path("a", count=400))
        assert min(part.count for part in store.plan_parts("a")) >= 32
        assert store.plan("a") == path("a", count=400)


STEPS = range(-6, 7)


def between(start: tuple[float, float], goal: tuple[float, float], name: str, length: float) -> PlanRecord:
    poses = np.zeros((2, 7))
    poses[:, :2], poses[:, 6] = (start, goal), 1.0
    return plan(name, poses=poses.tobytes(), start=(*start, 0.0), goal=(*goal, 0.0), length=length)


@pytest.fixture(scope="module")
def kept() -> list[PlanRecord]:
    """Return plans whose ends are around a corner of the grid of buckets, a few plans in each cell."""
    return [
        between((0.05 * x, 0.05 * y), (5.0, 0.05 * x), f"p{x}.{y}.{again}", 5.0 + 0.0625 * ((7 * x + 3 * y) % 11))
        for x in STEPS
        for y in STEPS
        for again in range(3)
    ]


@pytest.fixture
def store(tmp_path: Path, kept: list[PlanRecord]) -> Iterator[SqliteStore]:
    store = SqliteStore(tmp_path / "store.db")
    store.add_plans(kept)
    yield store
    store.close()


@pytest.mark.parametrize("limit", [0, 1, 5, 16, 60, 1000])
@pytest.mark.parametrize("tolerance", [0.0, 0.12, 0.25])
def test_the_shortest_plans_near_both_places_are_found(
    store: SqliteStore, kept: list[PlanRecord], tolerance: float, limit: int
) -> None:
    search = PlanStoreQuery("house", "v", (0.0, 0.0), (5.0, 0.0), tolerance)
    near = sorted(one.length for one in kept if search.joins(one.start[:2], one.goal[:2]))
    assert [head.length for head in store.find_plans(search, limit=limit)] == near[:limit]


def test_a_plan_is_found_once_if_two_buckets_have_the_same_hash(
    store: SqliteStore, kept: list[PlanRecord], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plan_rows, "buckets_near", lambda *sought: np.repeat(buckets_near(*sought), 2, axis=0))
    search = PlanStoreQuery("house", "v", (0.0, 0.0), (5.0, 0.0), 0.12)
    found = [head.id for head in store.find_plans(search, limit=1000)]
    assert sorted(found) == sorted(one.id for one in kept if search.joins(one.start[:2], one.goal[:2]))
