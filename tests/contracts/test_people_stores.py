"""The contract of every ``PeopleStore``."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from ppaas.errors import Conflict, InvalidInput
from ppaas.people.settings import CountingZone, PeopleSettings
from storage.people import HOUR, MapPeople, PeopleCount
from storage.ports import Store
from tests.support.storage.records import NOT_NAMES, user

DOOR = CountingZone("door", [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
COUNTED = PeopleSettings(rule="named", targets=[3], names={"3": "Zoë"}, zones=[DOOR], history=True)


def row(hour: int = 0, zone: str = "", people: int = 1, *, owner: str = "ann", map_id: str = "house") -> PeopleCount:
    return PeopleCount(owner, map_id, hour * HOUR, zone, people)


@pytest.fixture
def counting(store: Store) -> Store:
    for owner, map_id in (("ann", "house"), ("ann", "yard"), ("bob", "house")):
        store.put_people_settings(MapPeople(owner, map_id, COUNTED))
    return store


def test_settings_are_the_defaults_until_they_are_stored(store: Store) -> None:
    assert store.map_people("ann", "house").settings == PeopleSettings()
    store.put_people_settings(MapPeople("ann", "house", COUNTED))
    assert store.map_people("ann", "house").settings == COUNTED
    assert store.map_people("bob", "house").settings == store.map_people("ann", "yard").settings == PeopleSettings()


def test_settings_are_replaced_only_if_nobody_changed_them_first(store: Store) -> None:
    store.put_people_settings(MapPeople("ann", "house", COUNTED), instead_of=MapPeople("ann", "house"))
    with pytest.raises(Conflict):
        store.put_people_settings(MapPeople("ann", "house"), instead_of=MapPeople("ann", "house", COUNTED, HOUR))
    assert store.map_people("ann", "house").settings == COUNTED
    store.put_people_settings(MapPeople("ann", "house"), instead_of=MapPeople("ann", "house", COUNTED))
    assert store.map_people("ann", "house").settings == PeopleSettings()


def test_settings_of_a_map_and_maps_are_listed_in_order(store: Store) -> None:
    assert (store.people_maps(), store.people_of_map("house")) == ([], [])
    for owner, map_id in (("bob", "yard"), ("bob", "house"), ("ann", "house")):
        store.put_people_settings(MapPeople(owner, map_id))
    assert store.people_maps() == ["house", "yard"]
    assert [record.key for record in store.people_of_map("house")] == [("ann", "house"), ("bob", "house")]


def test_counts_are_listed_by_hour_and_zone_and_page_by_page(counting: Store) -> None:
    rows = [row(hour, zone, hour + 1) for hour in (2, 0, 10) for zone in ("door", "")]
    counting.add_people_counts([*rows, row(owner="bob"), row(map_id="yard")])
    found = counting.people_counts("ann", "house")
    assert found == sorted(rows)
    assert counting.people_counts("ann", "house", after=(2 * HOUR, ""), limit=2) == sorted(rows)[3:5]
    assert counting.people_counts("ann", "house", after=(10 * HOUR, "door")) == []
    assert counting.people_counts("ann", "house", limit=0) == []
    assert counting.people_counts("bob", "house") == [row(owner="bob")]


def test_adding_counts_again_keeps_the_larger_ones(counting: Store) -> None:
    counting.add_people_counts([row(people=3), row(people=5), row(people=4)])
    counting.add_people_counts([row(people=2), row(1, people=2)])
    counting.add_people_counts([row(people=2), row(1, people=3)])
    assert [count.people for count in counting.people_counts("ann", "house")] == [5, 3]


def test_concurrent_counts_keep_the_largest(counting: Store) -> None:
    with ThreadPoolExecutor(4) as threads:
        list(threads.map(lambda people: counting.add_people_counts([row(people=people)]), range(20)))
    assert counting.people_counts("ann", "house") == [row(people=19)]


def test_counts_without_settings_are_not_stored(counting: Store) -> None:
    counting.add_people_counts([row(owner="carl"), row(map_id="attic"), row()])
    assert counting.people_counts("ann", "house") == [row()]
    for owner, map_id in (("carl", "house"), ("ann", "attic")):
        counting.put_people_settings(MapPeople(owner, map_id))
        assert counting.people_counts(owner, map_id) == []


def test_counts_before_a_time_are_removed(counting: Store) -> None:
    counting.add_people_counts([*(row(hour) for hour in range(4)), row(owner="bob")])
    counting.remove_people_counts("ann", "house", before=2 * HOUR)
    assert [count.hour // HOUR for count in counting.people_counts("ann", "house")] == [2, 3]
    counting.remove_people_counts("ann", "house")
    assert counting.people_counts("ann", "house") == []
    assert counting.people_counts("bob", "house") == [row(owner="bob")]
    assert counting.map_people("ann", "house").settings == COUNTED
    counting.add_people_counts([row()])
    assert counting.people_counts("ann", "house") == [row()]


def test_people_of_a_removed_map_are_forgotten(counting: Store) -> None:
    counting.add_people_counts([row(), row(owner="bob"), row(map_id="yard")])
    counting.remove_people("house")
    counting.remove_people("house")
    assert counting.people_maps() == ["yard"]
    assert counting.map_people("ann", "house").settings == PeopleSettings()
    for owner in ("ann", "bob"):
        counting.put_people_settings(MapPeople(owner, "house"))
        assert counting.people_counts(owner, "house") == []
    assert counting.people_counts("ann", "yard") == [row(map_id="yard")]


def test_people_of_a_removed_user_are_forgotten(counting: Store) -> None:
    counting.add_user(user("ann"))
    counting.put_people_settings(MapPeople("ann", "house", COUNTED))
    counting.add_people_counts([row(), row(owner="bob")])
    counting.remove_user("ann")
    counting.add_user(user("ann"))
    assert counting.map_people("ann", "house").settings == PeopleSettings()
    assert [record.key for record in counting.people_of_map("house")] == [("bob", "house")]
    counting.put_people_settings(MapPeople("ann", "house"))
    assert counting.people_counts("ann", "house") == []
    assert counting.people_counts("bob", "house") == [row(owner="bob")]


@pytest.mark.parametrize(
    "count",
    [
        row(people=-1),
        row(people=1 << 40),
        row(-1),
        row(1 << 50),
        PeopleCount("ann", "house", HOUR + 1, "", 1),
        row(zone="x" * 65),
        row(zone="\ud800"),
    ],
    ids=repr,
)
def test_one_invalid_count_rejects_all_counts_of_a_call(counting: Store, count: PeopleCount) -> None:
    with pytest.raises(InvalidInput):
        counting.add_people_counts([row(), count])
    assert counting.people_counts("ann", "house") == []


@pytest.mark.parametrize("name", NOT_NAMES)
def test_invalid_names_are_refused(store: Store, name: str) -> None:
    calls: list[Callable[[], object]] = [
        lambda: store.people_of_map(name),
        lambda: store.remove_people(name),
    ]
    for pair in ((name, "house"), ("ann", name)):
        calls += [
            lambda pair=pair: store.map_people(*pair),  # type: ignore[misc]
            lambda pair=pair: store.put_people_settings(MapPeople(*pair)),  # type: ignore[misc]
            lambda pair=pair: store.people_counts(*pair),  # type: ignore[misc]
            lambda pair=pair: store.remove_people_counts(*pair),  # type: ignore[misc]
            lambda pair=pair: store.add_people_counts([PeopleCount(*pair, 0, "", 1)]),  # type: ignore[misc]
        ]
    for call in calls:
        with pytest.raises(InvalidInput):
            call()
