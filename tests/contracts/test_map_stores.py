"""What every ``MapStore`` promises."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import msgspec
import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.ports import MapStore
from storage.records import MapVersionRecord
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


def test_only_what_a_user_may_read_is_listed_for_that_user(map_store: MapStore) -> None:
    for map_id, owner, readers in (("a", "ann", ()), ("b", "ann", ("bob",)), ("c", "ann", ("*",)), ("d", "bob", ())):
        map_store.put_map(house(map_id, owner=owner, readers=readers))
    seen = {user: [head.id for head in map_store.maps(user)] for user in ("ann", "bob", "carl")}
    assert seen == {"ann": ["a", "b", "c"], "bob": ["b", "c", "d"], "carl": ["c"]}
    assert [head.id for head in map_store.maps("bob", after="b", limit=1)] == ["c"]


def test_every_version_is_kept_and_found_newest_first(map_store: MapStore) -> None:
    one, two = house(image=pgm(value=1), created=1.0), house(image=pgm(value=2), created=2.0)
    for record in (one, two, msgspec.structs.replace(one, created=3.0)):
        map_store.put_map(record)
    newest, oldest = map_store.versions("house")
    assert (newest, oldest) == (MapVersionRecord(2.0, two.version), MapVersionRecord(1.0, one.version))
    assert map_store.versions("house", limit=1) == [newest]
    assert map_store.versions("house", before=newest) == [oldest]
    assert map_store.map("house", two.version) == two
    assert map_store.map("house", one.version) == one
    assert map_store.map("house").created == 3.0
    with pytest.raises(NotFound, match="version of map 'house': 'f"):
        map_store.map("house", "f" * 64)
    with pytest.raises(InvalidInput):
        map_store.map("house", "../x")


def test_a_map_that_was_removed_comes_back_without_its_old_versions(map_store: MapStore) -> None:
    map_store.put_map(house(image=pgm(value=1)))
    map_store.remove_map("house")
    map_store.put_map(house(image=pgm(value=2)))
    assert [one.version for one in map_store.versions("house")] == [house(image=pgm(value=2)).version]


def test_what_is_said_of_a_map_changes_and_its_files_do_not(map_store: MapStore) -> None:
    map_store.put_map(house(readers=("bob",)))
    assert map_store.change_map("house", description="the ground floor") == without_files(
        house(readers=("bob",), description="the ground floor")
    )
    map_store.change_map("house", readers=())
    assert map_store.map("house") == house(description="the ground floor")
    assert map_store.map("house", house().version).description == "the ground floor"


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
    lambda store, map_id: store.versions(map_id),
    lambda store, map_id: store.map(map_id, "f" * 64),
    lambda store, map_id: store.change_map(map_id, readers=()),
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
