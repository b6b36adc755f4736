"""The contract of every ``BuildingStore``."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest
from msgspec.structs import replace

from ppaas.buildings.building import Building, DoorSettings, Floor, LiftSettings, WaySettings
from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.ports import Store
from tests.support.storage.records import NOT_NAMES, building, user


def test_a_building_is_returned_as_it_was_stored(store: Store) -> None:
    whole = Building(
        floors=(Floor(name="L1 ö", map="m1"), Floor(name="L2", map="m2", elevation=3.2, anchor=(0.1, -2.5, 3.1))),
        lifts=(LiftSettings(lift="east", robots=2, device="http://lift"),),
        doors=(DoorSettings(floor="L2", door="d 1", opens=1.5),),
        ways=(WaySettings(way="stairs", kind="stairs", length=7.5, labels={"legs": "yes"}),),
    )
    begun = building(readers=("bob", "*"), versions=3)
    given = replace(begun, present=replace(begun.present, building=whole))
    store.put_building(given)
    assert store.building("ann", "hq") == given


def test_a_building_that_does_not_exist_is_not_found(store: Store) -> None:
    store.put_building(building())
    for key in (("ann", "home"), ("bob", "hq")):
        for call in (store.building, store.remove_building):
            with pytest.raises(NotFound, match="building"):
                call(*key)
    assert store.buildings("bob") == []


def test_a_building_is_replaced_only_if_nobody_changed_it_first(store: Store) -> None:
    with pytest.raises(Conflict):
        store.put_building(building(versions=2), instead_of=building())
    store.put_building(building())
    with pytest.raises(Conflict, match="hq"):
        store.put_building(building(readers=("bob",)))
    store.put_building(building(versions=2), instead_of=building())
    with pytest.raises(Conflict):
        store.put_building(building(versions=3), instead_of=building())
    assert store.building("ann", "hq") == building(versions=2)


def test_of_concurrent_changes_of_a_building_one_is_made(store: Store) -> None:
    store.put_building(building())

    def change(number: int) -> bool:
        try:
            store.put_building(building(readers=(f"user{number}",), versions=2), instead_of=building())
        except Conflict:
            return False
        return True

    with ThreadPoolExecutor(4) as threads:
        assert sum(threads.map(change, range(12))) == 1


def test_a_building_is_removed_only_as_it_is(store: Store) -> None:
    store.put_building(building(versions=2))
    with pytest.raises(Conflict):
        store.remove_building("ann", "hq", instead_of=building())
    store.remove_building("ann", "hq", instead_of=building(versions=2))
    with pytest.raises(NotFound):
        store.remove_building("ann", "hq", instead_of=building(versions=2))
    store.put_building(building())
    store.remove_building("ann", "hq")
    assert store.building_users() == []


def test_buildings_are_listed_by_id_and_page_by_page(store: Store) -> None:
    for name in ("b2", "b10", "b1"):
        store.put_building(building(name))
    store.put_building(building("b3", "bob"))
    assert [one.id for one in store.buildings("ann")] == ["b1", "b10", "b2"]
    assert store.buildings("ann", after="b1", limit=1) == [building("b10")]
    assert store.buildings("ann", limit=0) == []
    assert store.building_users() == ["ann", "bob"]


def test_buildings_of_a_removed_user_are_forgotten(store: Store) -> None:
    for name in ("ann", "bob"):
        store.add_user(user(name))
        store.put_building(building(owner=name))
    store.remove_user("ann")
    assert store.building_users() == ["bob"]
    store.add_user(user("ann"))
    assert store.buildings("ann") == []
    store.put_building(building())
    assert store.building("ann", "hq") == building()


@pytest.mark.parametrize("name", NOT_NAMES)
def test_invalid_names_of_buildings_are_refused(store: Store, name: str) -> None:
    calls: list[Callable[[], object]] = [lambda: store.buildings(name)]
    for owner, of in (("ann", name), (name, "hq")):
        calls += [
            lambda owner=owner, of=of: store.put_building(building(of, owner)),  # type: ignore[misc]
            lambda owner=owner, of=of: store.building(owner, of),  # type: ignore[misc]
            lambda owner=owner, of=of: store.remove_building(owner, of),  # type: ignore[misc]
        ]
    for call in calls:
        with pytest.raises(InvalidInput, match="not a valid name"):
            call()
