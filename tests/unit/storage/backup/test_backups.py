"""Backups of stores of each kind, incremental and encrypted ones, and what is restored from them."""

from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import msgspec
import pytest

from ppaas.errors import Conflict, Damaged, InvalidInput, NotFound, Unavailable
from storage.backup.manifest import BackupManifest
from storage.backup.reading import Archive, LeftOut, kinds_of, restore_epochs
from storage.backup.repository import LOCK, Repository
from storage.backup.sealing import read_key
from storage.backup.writing import BackupWriter, Sources
from storage.files.store import FileMapStore
from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.migration.copying import Compared, compare, copy
from storage.migration.map_records import MAP_KINDS
from storage.migration.store_records import KINDS
from storage.records import CloneLogChange, Lease
from storage.sqlite.store import SqliteStore
from tests.support.storage.full_store import fill, fill_maps
from tests.support.storage.records import clone, house, pgm, plan, put_map, robot

SIZES = {
    "users": 3, "tokens": 3, "robots": 14, "URDFs": 2, "checkpoints": 5, "people": 2, "counts": 100, "tasks": 70,
    "buildings": 2, "webhooks": 2, "deliveries": 70,
    "plans": 80, "history": 3, "links": 1, "maps": 2,
}  # fmt: skip


@pytest.fixture
def stores() -> tuple[MemoryStore, MemoryMapStore]:
    """Return full stores."""
    store, maps = MemoryStore(), MemoryMapStore()
    fill(store)
    fill_maps(maps)
    return store, maps


@pytest.fixture
def place(tmp_path: Path) -> str:
    return str(tmp_path / "backups")


def back_up(place: str, store: Any, maps: Any = None, key: bytes | None = None) -> BackupManifest:
    repository = Repository.at(place, key, create=True)
    with repository.locked() as lock:
        writer = BackupWriter(repository, Sources(store, maps, {"store": "memory"}), lock.renew)
        list(writer.steps())
    return writer.manifest


def restore(
    place: str, store: Any, maps: Any, backup: str = "latest", key: bytes | None = None
) -> tuple[dict[str, Compared], list[LeftOut]]:
    """Restore a backup; return how stores and backup compare afterwards, and what was left out."""
    repository = Repository.at(place, key)
    archive, left_out = Archive(repository, repository.manifest(backup)), list[LeftOut]()
    kinds = [(kind, store) for kind in kinds_of(archive, KINDS, left_out)]
    kinds += [(kind, maps) for kind in kinds_of(archive, MAP_KINDS, left_out)]
    for kind, target in kinds:
        list(copy(kind, archive, target))
    found = {kind.name: list(compare(kind, archive, target))[-1] for kind, target in kinds}
    return found, [each for each in left_out if each.keys]


@pytest.fixture(params=["memory", "sqlite", pytest.param("cassandra", marks=pytest.mark.servers)])
def empty(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[Any, Any]]:
    """Return empty stores."""
    if request.param == "cassandra":
        yield request.getfixturevalue("cassandra_store"), FileMapStore(tmp_path / "maps")
    elif request.param == "memory":
        yield MemoryStore(), MemoryMapStore()
    else:
        with ExitStack() as stack:
            yield stack.enter_context(closing(SqliteStore(tmp_path / "store.db"))), FileMapStore(tmp_path / "maps")


def test_every_record_and_file_is_restored_into_stores_of_each_kind(
    stores: tuple[Any, Any], empty: tuple[Any, Any], place: str
) -> None:
    manifest = back_up(place, *stores)
    assert {kind: stream.records for kind, stream in manifest.streams.items()} == SIZES
    found, left_out = restore(place, *empty)
    assert {kind: (one.records, one.same, one.beyond) for kind, one in found.items()} == {
        kind: (size, size, 0) for kind, size in SIZES.items()
    }
    assert not left_out
    for kinds, source, target in ((KINDS, stores[0], empty[0]), (MAP_KINDS, stores[1], empty[1])):
        for kind in kinds:
            assert list(compare(kind, source, target))[-1].is_good, kind.name


def test_logs_of_clones_are_restored(place: str) -> None:
    source, target = MemoryStore(), MemoryStore()
    fill(source, plans=1)
    entries = {number: bytes([number]) * 200_000 for number in range(20)}
    source.save_clone(clone("tb1"), CloneLogChange("map", entries))
    source.save_clone(clone("tb1"), CloneLogChange("other", {3: b"x"}))
    assert len(back_up(place, source).logs) == 4
    restore(place, target, MemoryMapStore())
    assert dict(target.clone_log("ann", "tb1", "map")) == entries
    assert target.clone_log("ann", "tb1", "other") == [(3, b"x")]


def test_a_second_backup_adds_what_is_new(stores: tuple[Any, Any], place: str) -> None:
    store, maps = stores
    first = back_up(place, *stores)
    unchanged = back_up(place, *stores)
    assert unchanged.streams == first.streams
    store.add_plan(plan("new", created=900.0))
    again = back_up(place, *stores)
    assert again.streams["plans"].blocks[:-1] == first.streams["plans"].blocks
    assert again.streams["plans"].blocks[-1].records == 1
    put_map(maps, house("house", image=pgm(value=77), created=2000.0, readers=("carl",)))
    assert len(back_up(place, *stores).versions) == len(first.versions) + 1
    found, _ = restore(place, target := MemoryStore(), MemoryMapStore())
    assert all(one.is_good for one in found.values())
    assert target.plan("new") == store.plan("new")


def test_removed_and_replaced_plans_are_not_in_the_next_backup(stores: tuple[Any, Any], place: str) -> None:
    store = stores[0]
    back_up(place, *stores)
    store.remove_plan("p00001")
    old = store.plan("p00007")
    store.replace_plan(msgspec.structs.replace(old, cost=1.0), instead_of=old)
    assert back_up(place, *stores).streams["plans"].records == 79
    restore(place, target := MemoryStore(), MemoryMapStore())
    assert target.plan("p00007").cost == 1.0
    with pytest.raises(NotFound):
        target.plan("p00001")
    ids = Repository.at(place).ids()
    restore(place, earlier := MemoryStore(), MemoryMapStore(), ids[0])
    assert earlier.plan("p00007") == old
    assert earlier.plan("p00001").id == "p00001"


def test_what_belongs_to_nothing_is_left_out_and_named(place: str) -> None:
    """A store that is read while it changes may have lost the user of a token."""
    source, target = MemoryStore(), MemoryStore()
    fill(source, plans=1)
    repository = Repository.at(place, create=True)
    with repository.locked() as lock:
        steps = (writer := BackupWriter(repository, Sources(source), lock.renew)).steps()
        for step in steps:
            if step.kind == "users" and step.records == 3:
                break
        source.add_user(msgspec.structs.replace(source.user("ann"), id="late"))
        source.put_robot(robot("of-late", user="late"))
        source.put_urdf("late", "of-late", b"<robot/>")
        list(steps)
    assert writer.manifest.streams["robots"].records == 15
    found, left_out = restore(place, target, MemoryMapStore())
    assert all(one.is_good for one in found.values())
    assert all(("late" in str(key)) for each in left_out for key in each.keys)


def test_an_encrypted_backup_needs_its_key(stores: tuple[Any, Any], place: str, tmp_path: Path) -> None:
    key = read_key(tmp_path / "key", create=True)
    assert read_key(tmp_path / "key") == key
    assert (tmp_path / "key").stat().st_mode & 0o777 == 0o600
    back_up(place, *stores, key=key)
    stored = b"".join(file.read_bytes() for file in Path(place, "blocks").rglob("*") if file.is_file())
    assert b"ann" not in stored
    found, _ = restore(place, MemoryStore(), MemoryMapStore(), key=key)
    assert all(one.is_good for one in found.values())
    with pytest.raises(InvalidInput, match="give its key"):
        Repository.at(place)
    with pytest.raises(InvalidInput, match="another key"):
        Repository.at(place, read_key(tmp_path / "other", create=True))


def test_a_key_for_a_backup_that_has_none_is_refused(stores: tuple[Any, Any], place: str) -> None:
    back_up(place, *stores)
    with pytest.raises(InvalidInput, match="not encrypted"):
        Repository.at(place, bytes(32))


@pytest.mark.parametrize("text", ["", "abc", "zz" * 32, "ab" * 31])
def test_a_file_without_a_key_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "key").write_text(text)
    with pytest.raises(InvalidInput, match="64 hexadecimal digits"):
        read_key(tmp_path / "key")
    with pytest.raises(InvalidInput, match="no such file"):
        read_key(tmp_path / "missing")


@pytest.mark.parametrize("key", [None, bytes(32)])
@pytest.mark.parametrize("damage", ["changed", "cut", "missing", "another"])
def test_a_damaged_block_is_found(stores: tuple[Any, Any], place: str, damage: str, key: bytes | None) -> None:
    manifest = back_up(place, *stores, key=key)
    repository = Repository.at(place, key)
    archive = Archive(repository, manifest)
    assert list(archive.verify()) == []
    name = manifest.streams["plans"].blocks[0].name
    file = Path(place, "blocks", name[:2], name)
    data = file.read_bytes()
    other = next(each for each in Path(place, "blocks").rglob("*") if each.is_file() and each != file)
    if damage == "missing":
        file.unlink()
    else:
        middle = len(data) // 2
        changed = data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :]
        file.write_bytes({"changed": changed, "cut": data[:middle], "another": other.read_bytes()}[damage])
    assert [name in text for text in archive.verify()] == [True]
    with pytest.raises(Damaged):
        list(archive.pages("plans"))


def test_removing_backups_removes_the_blocks_that_no_other_needs(stores: tuple[Any, Any], place: str) -> None:
    store = stores[0]
    first = back_up(place, *stores)
    store.remove_plans("m0")
    second = back_up(place, *stores)
    repository = Repository.at(place)
    with repository.locked():
        assert repository.remove([first.id]) == len(first.blocks() - second.blocks()) > 0
    assert repository.ids() == [second.id]
    found, _ = restore(place, MemoryStore(), MemoryMapStore())
    assert all(one.is_good for one in found.values())


def test_blocks_of_a_backup_that_was_cut_off_are_used_by_the_next(stores: tuple[Any, Any], place: str) -> None:
    repository = Repository.at(place, create=True)
    with repository.locked() as lock:
        for step in BackupWriter(repository, Sources(*stores), lock.renew).steps():
            if step.kind == "maps":
                break
        repository.settle()
    assert Repository.at(place).ids() == []
    added = repository.added
    assert added
    whole = back_up(place, *stores)
    assert whole.added < added
    assert all(one.is_good for one in restore(place, MemoryStore(), MemoryMapStore())[0].values())


def test_one_process_writes_at_a_time(place: str) -> None:
    repository = Repository.at(place, create=True)
    with repository.locked(), pytest.raises(Conflict, match="in use by process"), Repository.at(place).locked():
        pass
    with repository.locked():  # it was given back
        pass


@pytest.mark.parametrize("lock", [{"host": "gone", "pid": 1, "renewed": 0.0}, None])
def test_the_lock_of_a_process_that_died_is_taken_over(place: str, lock: dict[str, Any] | None) -> None:
    repository = Repository.at(place, create=True)
    Path(place, LOCK).write_bytes(b"" if lock is None else msgspec.json.encode(lock))
    with repository.locked():
        pass
    assert not Path(place, LOCK).exists()


def test_a_place_without_backups_is_named(tmp_path: Path, place: str) -> None:
    with pytest.raises(NotFound, match="repository of backups"):
        Repository.at(place)
    (tmp_path / "empty").mkdir()
    with pytest.raises(NotFound, match="repository of backups"):
        Repository.at(str(tmp_path / "empty"))
    with pytest.raises(NotFound, match="backup"):
        Repository.at(place, create=True).manifest("latest")
    with pytest.raises(InvalidInput, match="give a folder"):
        Repository.at("ftp://host/place")


def test_a_backup_of_a_later_release_is_refused(stores: tuple[Any, Any], place: str) -> None:
    manifest = back_up(place, *stores)
    repository = Repository.at(place)
    later = msgspec.structs.replace(manifest, id="3", format=99, release="9.0.0")
    repository.add(later)
    with pytest.raises(Unavailable, match=r"9\.0\.0"):
        repository.manifest("3")
    assert repository.manifest(manifest.id) == manifest


def test_a_restored_lease_is_ahead_of_all_epochs_since(place: str) -> None:
    source, target = MemoryStore(), MemoryStore()
    none = source.lease("master")
    source.change_lease(Lease("master", "a", epoch=7), instead_of=none)
    manifest = back_up(place, source)
    assert manifest.epochs == {"master": 7}
    restore_epochs(manifest, target)
    assert target.lease("master").epoch > 1_000_000
    assert target.lease("master").holder == ""
