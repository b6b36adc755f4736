"""Migrations between stores of any kind, also interrupted ones."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import msgspec
import pytest

from ppaas.errors import Unavailable
from ppaas.plans.history import PlannerHistory
from storage.files.store import FileMapStore
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.migration.copying import Compared, Copied, StoredKind, compare, copy
from storage.migration.map_records import MAP_KINDS
from storage.migration.store_records import KINDS
from storage.people import PeopleCount
from storage.records import CloneLogChange, Publication
from storage.sqlite.store import SqliteStore
from storage.urls.opening import open_map_store, open_store
from tests.support.sources import ROOT
from tests.support.storage.full_store import fill, fill_maps
from tests.support.storage.records import clone, found_map, house, pgm, plan, propose, put_map, robot, token, user

SIZES = {
    "users": 3, "tokens": 3, "robots": 14, "URDFs": 2, "checkpoints": 5, "people": 2, "counts": 100, "tasks": 70,
    "buildings": 2, "webhooks": 2, "deliveries": 70,
    "plans": 80, "history": 3, "links": 1,
}  # fmt: skip


def migrate(kinds: tuple[StoredKind[Any], ...], source: Any, target: Any, **options: Any) -> dict[str, Copied]:
    return {kind.name: list(copy(kind, source, target, **options))[-1] for kind in kinds}


def check(kinds: tuple[StoredKind[Any], ...], source: Any, target: Any) -> dict[str, Compared]:
    return {kind.name: list(compare(kind, source, target))[-1] for kind in kinds}


def copied(done: dict[str, Copied]) -> dict[str, int]:
    return {name: one.copied for name, one in done.items()}


@pytest.fixture(
    params=["memory to sqlite", "sqlite to memory", pytest.param("sqlite to cassandra", marks=pytest.mark.servers)]
)
def stores(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[Any, Any]]:
    """Return a full store and an empty one."""
    kinds = request.param.split(" to ")
    with ExitStack() as stack:
        opened: list[Any] = []
        for kind in kinds:
            if kind == "cassandra":
                opened.append(request.getfixturevalue("cassandra_store"))
            else:
                store = MemoryStore() if kind == "memory" else SqliteStore(tmp_path / "store.db")
                opened.append(stack.enter_context(closing(store)))
        fill(opened[0])
        yield opened[0], opened[1]


def test_every_record_is_copied_once_and_compares_equal(stores: tuple[Any, Any]) -> None:
    assert copied(migrate(KINDS, *stores)) == SIZES
    found = check(KINDS, *stores)
    assert all(one.is_good and one.digest == one.digest_there for one in found.values())
    assert {name: (one.records, one.same, one.beyond) for name, one in found.items()} == {
        name: (size, size, 0) for name, size in SIZES.items()
    }
    assert {one.digest for one in check(KINDS, stores[1], stores[0]).values()} == {one.digest for one in found.values()}
    assert copied(migrate(KINDS, *stores)) == dict.fromkeys(SIZES, 0)


def test_records_that_only_the_target_has_stay_and_are_counted(stores: tuple[Any, Any]) -> None:
    source, target = stores
    target.add_user(user("dora"))
    target.add_plan(plan("other", map="m9"))
    assert migrate(KINDS, source, target)["users"].copied == 3
    found = check(KINDS, source, target)
    assert (found["users"].beyond, found["plans"].beyond, found["plans"].is_good) == (1, 1, True)
    assert target.user("dora") == user("dora")


def test_differing_records_stay_unless_they_are_overwritten(stores: tuple[Any, Any]) -> None:
    source, target = stores
    migrate(KINDS, source, target)
    target.change_user(user("bob", password_hash="changed"))
    target.put_robot(robot("tb5", cores=4.0))
    target.put_urdf("ann", "tb2", b"<other/>")
    old = target.plan("p00007")
    target.replace_plan(msgspec.structs.replace(old, cost=1.0), instead_of=old)
    again = migrate(KINDS, source, target)
    assert {name: (one.copied, one.different) for name, one in again.items() if one.copied + one.different} == {
        "users": (0, 1), "tokens": (1, 0), "robots": (0, 1), "URDFs": (0, 1), "plans": (0, 1),
    }  # fmt: skip
    found = check(KINDS, source, target)
    assert [name for name, one in found.items() if not one.is_good] == ["users", "robots", "URDFs", "plans"]
    assert (found["robots"].named, found["plans"].named) == (["ann/tb5"], ["p00007"])
    assert found["robots"].digest != found["robots"].digest_there
    migrate(KINDS, source, target, overwrite=True)
    assert all(one.is_good for one in check(KINDS, source, target).values())
    assert target.plan("p00007") == old


def test_grown_sums_are_counted_and_are_not_errors(stores: tuple[Any, Any]) -> None:
    source, target = stores
    migrate(KINDS, source, target)
    target.add_history([PlannerHistory("m0", "v", "dijkstra", 3, queries=1, failed=1)])
    assert migrate(KINDS, source, target, overwrite=True)["history"].different == 1
    found = check(KINDS, source, target)["history"]
    assert (found.different, found.is_good) == (1, True)


def test_counts_of_people_that_grew_are_brought_up_to_date_by_a_repeated_run(stores: tuple[Any, Any]) -> None:
    source, target = stores
    migrate(KINDS, source, target)
    source.add_people_counts([PeopleCount("ann", "m0", 0, "door", 9)])
    found = check(KINDS, source, target)["counts"]
    assert (found.different, found.is_good) == (1, True)
    assert migrate(KINDS, source, target, overwrite=True)["counts"].copied == 1
    assert check(KINDS, source, target)["counts"].same == 100


def test_later_additions_to_the_source_are_copied_by_the_next_run(stores: tuple[Any, Any]) -> None:
    source, target = stores
    migrate(KINDS, source, target)
    source.add_plan(plan("late", map="m1", created=1e9))
    source.add_token(token("f" * 64, user="bob"))
    assert not check(KINDS, source, target)["plans"].is_good
    assert {name: size for name, size in copied(migrate(KINDS, source, target)).items() if size} == {
        "tokens": 1, "plans": 1,
    }  # fmt: skip


LOG = {number: b"%d" % number for number in range(40)}


def test_logs_are_copied_with_their_checkpoints(stores: tuple[Any, Any]) -> None:
    source, target = stores
    source.save_clone(clone("tb1"), CloneLogChange("s1/grid_slam", LOG))
    target.save_clone(clone("tb1", nodes={}), CloneLogChange("s1/grid_slam", {99: b"of another run"}))
    assert copied(migrate(KINDS, source, target))["checkpoints"] == 5
    assert target.clone_log("ann", "tb1", "s1/grid_slam") == list(LOG.items())
    assert target.clone("ann", "tb1") == clone("tb1")


# -- maps --------------------------------------------------------------------------------------------------------------


@pytest.fixture(params=["memory to file", "file to memory", pytest.param("file to hdfs", marks=pytest.mark.servers)])
def map_stores(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Any, Any]:
    """Return a full map store and an empty one."""
    opened: list[Any] = []
    for kind in request.param.split(" to "):
        if kind == "hdfs":
            opened.append(request.getfixturevalue("hdfs_store"))
        else:
            opened.append(MemoryMapStore() if kind == "memory" else FileMapStore(tmp_path / "maps"))
    fill_maps(opened[0])
    return opened[0], opened[1]


def logs(store: Any, map_id: str) -> list[Any]:
    return [msgspec.structs.replace(one, number=0) for one in store.versions(map_id)]


def test_maps_are_copied_with_all_their_publications(map_stores: tuple[Any, Any]) -> None:
    source, target = map_stores
    assert migrate(MAP_KINDS, source, target)["maps"].copied == 2
    for map_id in ("alone", "house"):
        assert logs(target, map_id) == logs(source, map_id)
        assert found_map(target, map_id) == found_map(source, map_id)
        for version in {one.version for one in source.versions(map_id)}:
            assert found_map(target, map_id, version) == found_map(source, map_id, version)
    assert [one.restored for one in target.versions("house")] == [True, False, False, False, False]
    found = check(MAP_KINDS, source, target)["maps"]
    assert (found.records, found.same, found.beyond, found.is_good) == (2, 2, 0, True)
    assert migrate(MAP_KINDS, source, target)["maps"].copied == 0


def test_versions_that_wait_are_copied(map_stores: tuple[Any, Any]) -> None:
    source, target = map_stores
    put_map(source, house(image=pgm(value=76), zones=b"of the hall"))
    migrate(MAP_KINDS, source, target)
    for number, keeps in ((77, frozenset()), (78, frozenset({"zones"}))):
        propose(source, house(image=pgm(value=number)), author="bob", message="a new wall", keeps=keeps)
    assert migrate(MAP_KINDS, source, target)["maps"].copied == 1
    waiting = [[msgspec.structs.replace(one, number=0) for one in store.reviews("house")] for store in map_stores]
    assert waiting[0] == waiting[1]
    assert [one.keeps_zones for one in waiting[1]] == [True, False]
    assert check(MAP_KINDS, source, target)["maps"].is_good


def test_later_publications_in_the_source_are_copied_by_the_next_run(map_stores: tuple[Any, Any]) -> None:
    source, target = map_stores
    migrate(MAP_KINDS, source, target)
    later = {"created": 50.0, "image": None, "octomap": b"a tree"}
    put_map(source, house("alone", "bob", readers=("ann", "*"), description="one of its kind", **later))
    assert migrate(MAP_KINDS, source, target)["maps"].copied == 1
    assert logs(target, "alone") == logs(source, "alone")
    assert check(MAP_KINDS, source, target)["maps"].is_good


def test_a_map_that_diverged_in_the_target_stays_unless_overwritten(
    map_stores: tuple[Any, Any],
) -> None:
    source, target = map_stores
    migrate(MAP_KINDS, source, target)
    first = source.versions("house")[-1].version
    target.roll_back(first, Publication("house", "bob", 200.0, owner="ann"))
    assert migrate(MAP_KINDS, source, target)["maps"].different == 1
    assert check(MAP_KINDS, source, target)["maps"].named == ["house"]
    migrate(MAP_KINDS, source, target, overwrite=True)
    assert logs(target, "house") == logs(source, "house")
    target.change_map("house", readers=("*",))
    assert migrate(MAP_KINDS, source, target)["maps"].different == 1
    migrate(MAP_KINDS, source, target, overwrite=True)
    assert check(MAP_KINDS, source, target)["maps"].is_good


def test_a_damaged_file_in_the_target_is_found(tmp_path: Path) -> None:
    source, target = MemoryMapStore(), FileMapStore(tmp_path)
    fill_maps(source)
    migrate(MAP_KINDS, source, target)
    version = source.map_head("alone").present
    damaged = next(path for path in tmp_path.rglob(version.files["image"].sha256) if "alone" in str(path))
    damaged.write_bytes(damaged.read_bytes()[:-1] + b"!")
    with pytest.raises(Unavailable, match="is damaged"):
        check(MAP_KINDS, source, target)


# -- interrupted migrations --------------------------------------------------------------------------------------------


def kill_after(source: str, target: str, writes: int) -> int:
    """Migrate in a process that is killed after a number of writes; return its exit status."""
    command = [sys.executable, "-m", "tests.support.storage.killed_migration", source, target, str(writes)]
    return subprocess.run(command, cwd=ROOT, check=False).returncode


@pytest.mark.parametrize("writes", [5, 24])
def test_a_killed_migration_continues_where_it_stopped(tmp_path: Path, writes: int) -> None:
    source_url, target_url = (f"sqlite://{tmp_path / name}.db" for name in ("from", "to"))
    source = open_store(source_url)
    fill(source)
    assert kill_after(source_url, target_url, writes) == -signal.SIGKILL
    target = open_store(target_url)
    left = sum(one.missing for one in check(KINDS, source, target).values())
    assert 0 < left < sum(SIZES.values())
    assert sum(copied(migrate(KINDS, source, target)).values()) == left
    assert all(one.is_good and not one.beyond for one in check(KINDS, source, target).values())
    for store in (source, target):
        store.close()


@pytest.mark.parametrize("writes", [1, 5])
def test_a_killed_migration_of_maps_copies_the_missing_publications(tmp_path: Path, writes: int) -> None:
    source_url, target_url = (f"file://{tmp_path / name}" for name in ("from", "to"))
    source = open_map_store(source_url)
    fill_maps(source)
    assert kill_after(source_url, target_url, writes) == -signal.SIGKILL
    target = open_map_store(target_url)
    assert not check(MAP_KINDS, source, target)["maps"].is_good
    assert migrate(MAP_KINDS, source, target)["maps"].different == 0
    assert check(MAP_KINDS, source, target)["maps"].is_good
    assert logs(target, "house") == logs(source, "house")
