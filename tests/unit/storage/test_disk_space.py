"""Disk space: the reserve, stores that refuse new data without it, and revocations on a full disk."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from storage import disk_space
from storage.disk_space import (
    MAX_RESERVE,
    MIN_RESERVE,
    REFUSED,
    REFUSED_TOKENS,
    RESERVE,
    SLOT,
    SLOTS,
    DiskReserve,
    DiskSpace,
    RefusedTokenFile,
)
from storage.ports import MapStore, Store
from storage.records import Token
from storage.urls.opening import open_map_store, open_store
from tests.support.storage.records import house, plan, put_map, robot, user

MB = 1 << 20


class Disk:
    """A disk of 100 MiB whose free space a test sets; the reserve takes space of it."""

    def __init__(self, total: int = 100 * MB) -> None:
        self.total, self.others, self.files = total, 0, 1000

    def of(self, folder: Path) -> DiskSpace:
        reserve = folder / RESERVE
        used = self.others + (reserve.stat().st_size if reserve.exists() else 0)
        return DiskSpace(self.total, max(self.total - used, 0), self.files)


@pytest.fixture
def disk() -> Disk:
    return Disk()


@pytest.fixture
def reserve(tmp_path: Path, disk: Disk) -> DiskReserve:
    return DiskReserve(tmp_path, disk.of)


def test_space_is_set_aside_at_the_start(reserve: DiskReserve, tmp_path: Path) -> None:
    assert reserve.keep() == "ok"
    assert (tmp_path / RESERVE).stat().st_size == MIN_RESERVE
    assert (tmp_path / RESERVE).stat().st_blocks * 512 >= MIN_RESERVE


def test_a_disk_with_little_space_is_low_before_it_is_full(reserve: DiskReserve, disk: Disk) -> None:
    reserve.keep()
    disk.others = 95 * MB
    assert reserve.keep() == "low"
    assert not reserve.is_full()


def test_a_full_disk_gives_the_reserve_up_and_stays_full_until_there_is_space_for_another(
    reserve: DiskReserve, disk: Disk, tmp_path: Path
) -> None:
    reserve.keep()
    disk.others = 99 * MB
    assert reserve.is_full()
    assert reserve.keep() == "full"
    assert not (tmp_path / RESERVE).exists()
    assert reserve.space().free == MB
    assert reserve.keep() == "full"
    disk.others = 97 * MB
    assert reserve.keep() == "low"
    disk.others = 50 * MB
    assert reserve.keep() == "ok"
    assert (tmp_path / RESERVE).exists()


def test_a_disk_on_which_no_file_can_be_created_is_full(reserve: DiskReserve, disk: Disk) -> None:
    reserve.keep()
    disk.files = 0
    assert reserve.keep() == "full"


def test_every_process_sees_that_the_reserve_was_given_up(reserve: DiskReserve, disk: Disk, tmp_path: Path) -> None:
    other = DiskReserve(tmp_path, disk.of)
    reserve.keep()
    assert not other.is_full()
    disk.others = 99 * MB + MB // 2
    reserve.keep()
    assert other.is_full()


def test_the_size_of_the_reserve_has_bounds(reserve: DiskReserve) -> None:
    assert reserve.size(DiskSpace(1 << 50, 0, 1)) == MAX_RESERVE
    assert reserve.size(DiskSpace(0, 0, 1)) == MIN_RESERVE


def test_a_real_disk_is_measured(tmp_path: Path) -> None:
    space = DiskSpace.of(tmp_path)
    assert 0 < space.free <= space.total
    assert space.files > 0


def test_a_disk_that_cannot_be_measured_does_not_count_as_full(tmp_path: Path) -> None:
    assert not DiskReserve(tmp_path / "nowhere").is_full()


def test_the_reserve_is_removed_with_its_owner(reserve: DiskReserve, tmp_path: Path) -> None:
    reserve.keep()
    reserve.release()
    reserve.release()
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    DiskReserve(tmp_path).keep()
    opened = open_store(f"sqlite://{tmp_path}/store.sqlite", reserve=tmp_path)
    yield opened
    opened.close()


@pytest.fixture
def maps(tmp_path: Path) -> MapStore:
    DiskReserve(tmp_path).keep()
    return open_map_store(f"file://{tmp_path}/maps", reserve=tmp_path)


def fill_disk(folder: Path) -> None:
    (folder / RESERVE).unlink()  # as the owner of the folder does when the disk is full


# Stores on a full disk: nothing new is stored, and calls that withdraw a right or free space still work.


def test_a_full_disk_stores_no_new_data(store: Store, tmp_path: Path) -> None:
    store.add_user(user("ann"))
    store.put_robot(robot("tb1"))
    fill_disk(tmp_path)
    for refused in (
        lambda: store.add_user(user("bob")),
        lambda: store.put_robot(robot("tb2")),
        lambda: store.put_urdf("ann", "tb1", b"<robot/>"),
        lambda: store.add_plan(plan("p1")),
    ):
        with pytest.raises(Unavailable, match="the disk of the cloud is full: an administrator must free space"):
            refused()
    assert [one.id for one in store.users()] == ["ann"]


def test_rights_can_be_given_and_withdrawn_and_data_removed_on_a_full_disk(store: Store, tmp_path: Path) -> None:
    store.add_user(user("ann"))
    store.put_robot(robot("tb1"))
    fill_disk(tmp_path)
    store.add_token(Token("hash", "ann", 2e9))
    store.remove_token("hash")
    store.change_user(user("ann"))
    store.remove_robot("ann", "tb1")
    store.remove_user("ann")
    assert store.users() == []


def test_a_full_disk_takes_no_map_but_changes_readers_and_removes_maps(maps: MapStore, tmp_path: Path) -> None:
    put_map(maps, house())
    fill_disk(tmp_path)
    with pytest.raises(Unavailable, match="the disk of the cloud is full"):
        put_map(maps, house(map_id="cellar"))
    assert maps.change_map("house", readers=()).readers == ()
    maps.remove_map("house")
    assert maps.maps() == []


def test_data_is_stored_again_once_there_is_space(store: Store, tmp_path: Path) -> None:
    fill_disk(tmp_path)
    with pytest.raises(Unavailable):
        store.add_user(user("ann"))
    DiskReserve(tmp_path).keep()
    store.add_user(user("ann"))


def test_every_refused_method_is_one_of_the_ports() -> None:
    assert set(dir(Store)) | set(dir(MapStore)) >= REFUSED


def test_a_store_elsewhere_is_not_guarded(tmp_path: Path) -> None:
    assert type(open_store("memory:", reserve=tmp_path)) is type(open_store("memory:"))


def test_the_log_of_an_sqlite_file_is_emptied_to_free_space(store: Store, tmp_path: Path) -> None:
    store.add_user(user("ann"))
    log = tmp_path / "store.sqlite-wal"
    assert log.stat().st_size > 0
    store.shrink_log()  # type: ignore[attr-defined]
    assert log.stat().st_size == 0
    assert [one.id for one in store.users()] == ["ann"]


HASHES = [f"{number:064x}" for number in range(5)]


def opened(folder: Path, slots: int = SLOTS) -> tuple[RefusedTokenFile, list[tuple[str, str]]]:
    file = RefusedTokenFile(folder, slots)
    return file, file.open()


# File of revoked tokens that are not removed from the store yet.


def test_tokens_are_there_after_a_restart_until_they_are_removed(tmp_path: Path) -> None:
    file, found = opened(tmp_path)
    assert found == []
    for token_hash in HASHES:
        file.add("a" * 64, token_hash)
    file.add("a" * 64, HASHES[0])
    file.remove("a" * 64, HASHES[1])
    again, found = opened(tmp_path)
    assert found == [("a" * 64, token_hash) for number, token_hash in enumerate(HASHES) if number != 1]
    again.add("bob", HASHES[1])
    assert sorted(opened(tmp_path)[1])[-1] == ("bob", HASHES[1])


def test_the_file_takes_its_space_before_it_is_needed(tmp_path: Path) -> None:
    file, _ = opened(tmp_path)
    path = tmp_path / REFUSED_TOKENS
    before = path.stat()
    assert before.st_size == SLOT * SLOTS and before.st_blocks * 512 >= before.st_size, "no holes"
    assert before.st_mode & 0o077 == 0
    for token_hash in HASHES:
        file.add("ann", token_hash)
    assert path.stat().st_blocks == before.st_blocks
    assert path.stat().st_ino == before.st_ino, "it is written in place"


def test_tokens_without_space_are_not_acknowledged(tmp_path: Path) -> None:
    file, _ = opened(tmp_path, slots=2)
    for token_hash in HASHES[:2]:
        file.add("ann", token_hash)
    with pytest.raises(Unavailable, match="revoke it again"):
        file.add("ann", HASHES[2])
    file.remove("ann", HASHES[0])
    file.add("ann", HASHES[2])
    assert sorted(opened(tmp_path, slots=2)[1]) == [("ann", HASHES[1]), ("ann", HASHES[2])]


def test_a_token_that_was_half_written_is_none(tmp_path: Path) -> None:
    file, _ = opened(tmp_path)
    for token_hash in HASHES[:3]:
        file.add("ann", token_hash)
    path = tmp_path / REFUSED_TOKENS
    content = bytearray(path.read_bytes())
    content[SLOT + 40] ^= 1
    path.write_bytes(content)
    assert opened(tmp_path)[1] == [("ann", HASHES[0]), ("ann", HASHES[2])]


def test_without_space_for_the_file_nothing_is_acknowledged(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    file, found = opened(tmp_path / "missing")
    assert found == [] and "cannot be kept" in caplog.text
    with pytest.raises(Unavailable, match="could not be stored"):
        file.add("ann", HASHES[0])


def test_a_disk_that_fails_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, _ = opened(tmp_path)
    file.add("ann", HASHES[0])

    def fail(_handle: int) -> None:
        raise OSError(5, "Input/output error")

    with monkeypatch.context() as patch:
        patch.setattr(disk_space.os, "fdatasync", fail)
        with pytest.raises(Unavailable, match="Input/output error"):
            file.add("ann", HASHES[1])
        file.remove("ann", HASHES[0])
    assert (tmp_path / REFUSED_TOKENS).stat().st_size == SLOT * SLOTS
