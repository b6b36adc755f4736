"""Stores on a full disk: nothing new is stored, and calls that withdraw a right or free space still work."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from ppaas.errors import Unavailable
from storage.disk_space.guarded import REFUSED
from storage.disk_space.reserve import RESERVE, DiskReserve
from storage.ports import MapStore, Store
from storage.records import Token
from storage.urls.opening import open_map_store, open_store
from tests.support.storage.records import house, plan, put_map, robot, user


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
