"""Index of buildings by the maps of their floors."""

from typing import Any

import pytest

from engine.control.journeys.building_index import FRESH, BuildingIndex
from ppaas.buildings.building import Building, Floor
from storage.buildings.records import BuildingRecord, BuildingVersion
from storage.memory.store import MemoryStore


class CountedStore(MemoryStore):
    """Store that counts how often all buildings of a user are read."""

    lists = 0

    def buildings(self, user: str, **limits: Any) -> list[BuildingRecord]:
        self.lists += 1
        return super().buildings(user, **limits)

    def put(self, user: str, name: str, *maps: str, readers: tuple[str, ...] = ()) -> None:
        floors = tuple(Floor(name=map_id, map=map_id) for map_id in maps)
        version = BuildingVersion(number=1, building=Building(floors=floors), author=user, created=1.0)
        self.put_building(BuildingRecord(user=user, id=name, present=version, readers=readers))


@pytest.fixture
def store() -> CountedStore:
    made = CountedStore()
    made.put("bob", "hotel", "m1", "m2", readers=("ann",))
    made.put("carol", "office", "m1")
    return made


def found(index: BuildingIndex, user: str, map_id: str) -> str | None:
    record = index.with_floor(user, map_id)
    return None if record is None else record.id


def test_the_building_of_a_map_is_found_without_reading_all_each_time(store: CountedStore) -> None:
    index = BuildingIndex(store, lambda: 0.0)
    assert [found(index, "ann", "m2") for _ in range(5)] == ["hotel"] * 5
    assert store.lists == 2
    assert found(index, "carol", "m1") == "office"
    assert store.lists == 2


def test_the_users_own_building_comes_first_once_the_index_is_old(store: CountedStore) -> None:
    now = 0.0
    index = BuildingIndex(store, lambda: now)
    assert found(index, "ann", "m1") == "hotel"
    store.put("ann", "annex", "m1")
    now = FRESH + 0.1
    assert found(index, "ann", "m1") == "annex"


def test_what_is_removed_or_not_readable_any_more_is_not_found_and_what_is_new_is(store: CountedStore) -> None:
    index = BuildingIndex(store, lambda: 0.0)
    assert found(index, "ann", "m1") == "hotel"
    store.remove_building("bob", "hotel")
    assert found(index, "ann", "m1") is None, "carol's is not for ann"
    store.put("bob", "hotel", "m3", readers=("*",))
    assert found(index, "ann", "m1") is None
    assert found(index, "ann", "m3") == "hotel"
