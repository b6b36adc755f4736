"""What every ``MapStore`` promises."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import msgspec
import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.ports import MapStore
from storage.versions import map_version, without_files
from tests.support.records import NOT_NAMES, house, pgm


def test_a_map_is_found_as_it_was_published(map_store: MapStore) -> None:
    record = house(readers=("bob", "*"))
    map_store.put_map(record)
    assert map_store.map("house") == record


def test_the_head_of_a_map_is_all_but_its_files(map_store: MapStore) -> None:
    map_store.put_map(house(readers=("bob",)))
    assert map_store.map_head("house") == without_files(house(readers=("bob",)))


def test_empty_files_are_files(map_store: MapStore) -> None:
    map_store.put_map(house(image=b""))
    assert map_store.map("house").image == b""


def test_the_last_version_is_the_present_one(map_store: MapStore) -> None:
    first, second = house(image=pgm(value=0)), house(image=pgm(value=254))
    assert first.version != second.version
    for record in (first, second, first):
        map_store.put_map(record)
        assert map_store.map("house") == record


def test_readers_change_without_a_new_version(map_store: MapStore) -> None:
    map_store.put_map(house(readers=("bob",)))
    map_store.put_map(house(readers=()))
    assert map_store.map("house").readers == ()


def test_heads_come_sorted_by_id(map_store: MapStore) -> None:
    for map_id in ("depot", "house", "Attic"):
        map_store.put_map(house(map_id))
    assert map_store.maps() == [without_files(house(map_id)) for map_id in ("Attic", "depot", "house")]


def test_a_map_does_not_change_hands(map_store: MapStore) -> None:
    map_store.put_map(house(owner="ann"))
    with pytest.raises(Conflict, match="house"):
        map_store.put_map(house(owner="bob"))
    assert map_store.map("house").owner == "ann"


def test_one_of_many_who_take_an_id_at_once_gets_it(map_store: MapStore) -> None:
    start = Barrier(6)

    def publish(owner: str) -> str | None:
        start.wait()
        try:
            map_store.put_map(house(owner=owner))
        except Conflict:
            return None
        return owner

    with ThreadPoolExecutor(6) as threads:
        winners = [owner for owner in threads.map(publish, "abcdef") if owner]
    assert winners == [map_store.map_head("house").owner]


def test_a_removed_map_is_gone_and_its_id_free(map_store: MapStore) -> None:
    map_store.put_map(house(owner="ann"))
    map_store.remove_map("house")
    with pytest.raises(NotFound):
        map_store.map("house")
    assert map_store.maps() == []
    map_store.put_map(house(owner="bob"))
    assert map_store.map("house").owner == "bob"


def test_a_version_that_is_not_that_of_the_files_is_refused(map_store: MapStore) -> None:
    with pytest.raises(InvalidInput, match="version"):
        map_store.put_map(msgspec.structs.replace(house(), image=pgm(value=7)))
    assert map_store.maps() == []


CALLS_BY_ID: list[Callable[[MapStore, str], object]] = [
    lambda store, map_id: store.map(map_id),
    lambda store, map_id: store.map_head(map_id),
    lambda store, map_id: store.remove_map(map_id),
]


@pytest.mark.parametrize("call", CALLS_BY_ID)
def test_what_is_not_there_is_not_found(map_store: MapStore, call: Callable[[MapStore, str], object]) -> None:
    with pytest.raises(NotFound, match="nowhere"):
        call(map_store, "nowhere")


@pytest.mark.parametrize("name", NOT_NAMES)
def test_ids_that_are_no_names_are_refused_wherever_they_are_given(map_store: MapStore, name: str) -> None:
    for call in (*CALLS_BY_ID, lambda store, map_id: store.put_map(house(map_id))):
        with pytest.raises(InvalidInput):
            call(map_store, name)
    assert map_store.maps() == []


def test_the_border_between_the_files_counts_for_the_version() -> None:
    assert map_version(b"ab", b"c") != map_version(b"a", b"bc")
