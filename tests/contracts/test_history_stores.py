"""The contract of every ``HistoryStore``."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import pytest

from ppaas.errors import InvalidInput
from ppaas.plans.history import LinkHistory, PlannerHistory, computed_row, failed_row, found_row
from storage.ports import Store
from tests.support.storage.records import NOT_NAMES


def key(map_id: str = "house", version: str = "v1", planner: str = "dijkstra", bucket: int = 3):
    return map_id, version, planner, bucket


def test_rows_added_under_one_key_are_summed(store: Store) -> None:
    store.add_history([computed_row(key(), 0.25), failed_row(key()), found_row(key(), "stitched")])
    store.add_history([found_row(key(), "reused"), computed_row(key(), 0.5)])
    (row,) = store.history("house")
    assert row.key == key()
    assert (row.queries, row.failed, row.computed, row.reused, row.stitched) == (5, 1, 2, 1, 1)
    assert row.micros == 750_000


def test_rows_are_sorted_and_filtered_by_map_and_version(store: Store) -> None:
    keys = [key(version="v2"), key(bucket=10), key(planner="astar"), key("depot"), key(bucket=2)]
    store.add_history(failed_row(each) for each in keys)
    assert [row.key for row in store.history("house")] == sorted(each for each in keys if each[0] == "house")
    assert [row.key for row in store.history("house", "v2")] == [key(version="v2")]
    assert store.history("nowhere") == []


def test_concurrent_additions_lose_nothing(store: Store) -> None:
    with ThreadPoolExecutor(4) as threads:
        list(threads.map(lambda _: store.add_history([failed_row(key())]), range(40)))
    assert [row.failed for row in store.history("house")] == [40]


def test_one_invalid_row_rejects_all_rows_of_a_call(store: Store) -> None:
    with pytest.raises(InvalidInput):
        store.add_history([failed_row(key()), PlannerHistory(*key(), queries=-1)])
    assert store.history("house") == []


@pytest.mark.parametrize(
    "row",
    [
        PlannerHistory(*key(bucket=-1)),
        PlannerHistory(*key(bucket=64)),
        PlannerHistory(*key(), micros=1 << 60),
        PlannerHistory(*key(version="")),
    ],
)
def test_invalid_rows_are_refused(store: Store, row: PlannerHistory) -> None:
    with pytest.raises(InvalidInput):
        store.add_history([row])


def test_the_last_row_of_a_link_is_kept(store: Store) -> None:
    rows = [LinkHistory(name, 0.001, 2e8, 4, 10.0) for name in ("m2", "m1")]
    for row in (*rows, LinkHistory("m1", 0.002, 1e8, 5, 11.0)):
        store.put_link(row)
    assert store.links() == [LinkHistory("m1", 0.002, 1e8, 5, 11.0), rows[0]]


@pytest.mark.parametrize("number", [-1.0, float("nan"), float("inf")])
def test_a_link_with_invalid_numbers_is_refused(store: Store, number: float) -> None:
    with pytest.raises(InvalidInput):
        store.put_link(LinkHistory("m1", number, 1e8, 1, 0.0))
    assert store.links() == []


@pytest.mark.parametrize("name", NOT_NAMES)
def test_invalid_names_are_refused(store: Store, name: str) -> None:
    calls: list[Callable[[], object]] = [
        lambda: store.history(name),
        lambda: store.remove_history(name),
        lambda: store.add_history([failed_row(key(name))]),
        lambda: store.add_history([failed_row(key(planner=name))]),
        lambda: store.put_link(LinkHistory(name, 0.0, 1.0, 1, 0.0)),
    ]
    for call in calls:
        with pytest.raises(InvalidInput):
            call()


def test_maps_with_history_are_listed_once(store: Store) -> None:
    assert store.history_maps() == []
    store.add_history([PlannerHistory(name, version, "dijkstra", 3) for name in ("yard", "house") for version in "ab"])
    assert store.history_maps() == ["house", "yard"]


def test_only_the_history_of_the_given_map_is_removed(store: Store) -> None:
    store.add_history([failed_row(key(name, version)) for name in ("house", "house2", "yard") for version in "ab"])
    store.remove_history("house")
    assert store.history("house") == []
    assert store.history_maps() == ["house2", "yard"]
    store.remove_history("house")
    store.add_history([failed_row(key())])
    assert [row.failed for row in store.history("house")] == [1]
