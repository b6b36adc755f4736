"""A client that reads a list page by page sees each record once, even if records are added or removed meanwhile."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from storage.memory.maps import MemoryMapStore
from storage.memory.store import MemoryStore
from storage.ports import MapStore, Store
from storage.records import MapVersionRecord
from storage.sharing_records import Share
from tests.support.storage.records import house, pgm, plan, put_map, robot, token, user

Fetch = Callable[[Any, int], list[Any]]

LISTS: dict[str, tuple[Callable[[Store, Any, int], list[Any]], Callable[[Any], Any], Any]] = {
    "users": (lambda store, key, limit: store.users(after=key, limit=limit), lambda one: one.id, ""),
    "tokens": (lambda store, key, limit: store.tokens("u0", after=key, limit=limit), lambda one: one.hash, ""),
    "robots": (lambda store, key, limit: store.robots("ann", after=key, limit=limit), lambda one: one.id, ""),
    "plans": (
        lambda store, key, limit: store.plans("house", before=key, limit=limit),
        lambda one: (one.created, one.id),
        None,
    ),
    "shared robots": (
        lambda store, key, limit: store.robots_shared_with("bob", after=key, limit=limit),
        lambda one: (one.user, one.id),
        ("", ""),
    ),
}


def all_pages(fetch: Fetch, key_of: Callable[[Any], Any], first: Any, limit: int) -> list[Any]:
    """Return all records of a list, page by page."""
    found: list[Any] = []
    key = first
    while page := fetch(key, limit):
        assert len(page) <= limit
        found += page
        key = key_of(page[-1])
    return found


def fill(store: Store, count: int) -> None:
    for number in range(count):
        store.add_user(user(f"u{number}"))
        store.add_token(token(f"{number:064}", user="u0"))
        store.put_robot(robot(f"tb{number}", shares=(Share("bob", "look"),)))
        store.add_plan(plan(f"p{number}", created=float(number // 2)))


@pytest.mark.parametrize("name", LISTS)
@pytest.mark.parametrize("limit", [1, 2, 5, 7])
def test_pages_together_contain_the_whole_list(store: Store, name: str, limit: int) -> None:
    fill(store, 5)
    fetch, key_of, first = LISTS[name]
    whole = fetch(store, first, 1000)
    assert len(whole) == 5
    assert all_pages(lambda key, most: fetch(store, key, most), key_of, first, limit) == whole


def test_a_page_may_start_after_a_removed_record(store: Store) -> None:
    fill(store, 5)
    [*_, last] = store.plans("house", limit=2)
    store.remove_plan(last.id)
    store.add_plan(plan("new", created=99.0))
    rest = store.plans("house", before=(last.created, last.id))
    assert [one.id for one in rest] == ["p2", "p1", "p0"]


@pytest.mark.parametrize("limit", [1, 2, 3])
def test_maps_and_their_versions_are_paged(map_store: MapStore, limit: int) -> None:
    for number in range(3):
        put_map(map_store, house(f"m{number}"))
        put_map(map_store, house("m0", image=pgm(value=number), created=float(number)))
    ids = all_pages(lambda key, most: map_store.maps(after=key, limit=most), lambda one: one.id, "", limit)
    assert [one.id for one in ids] == ["m0", "m1", "m2"]

    def versions(key: int | None, most: int) -> list[MapVersionRecord]:
        return map_store.versions("m0", before=key, limit=most)

    assert all_pages(versions, lambda one: one.number, None, limit) == map_store.versions("m0")


@given(st.lists(st.sampled_from(["add", "remove", "page"]), max_size=30), st.integers(1, 3), st.randoms())
@settings(suppress_health_check=[HealthCheck.too_slow])
def test_remaining_records_are_seen_once_despite_changes(steps: list[str], limit: int, random: Any) -> None:
    store = MemoryStore()
    staying = {f"s{number}" for number in range(5)}
    for name in staying:
        store.put_robot(robot(name))
    seen: list[str] = []
    for step in [*steps, *["page"] * 40]:
        name = f"{random.choice('rt')}{random.randrange(9)}"
        if step == "add":
            store.put_robot(robot(name))
        elif step == "remove" and name in [one.id for one in store.robots("ann")]:
            store.remove_robot("ann", name)
        elif step == "page":
            seen += [one.id for one in store.robots("ann", after=seen[-1] if seen else "", limit=limit)]
    assert len(seen) == len(set(seen))
    assert staying <= set(seen)


def test_a_page_of_maps_reads_only_its_own_records(monkeypatch: pytest.MonkeyPatch) -> None:
    maps = MemoryMapStore()
    for number in range(20):
        put_map(maps, house(f"m{number:02}"))
    examined: list[str] = []
    record = type(maps.map_head("m00"))
    readable = record.readable_by

    def count(self: Any, reader: str) -> bool:
        examined.append(self.id)
        return readable(self, reader)

    monkeypatch.setattr(record, "readable_by", count)
    assert len(maps.maps("ann", after="m04", limit=3)) == 3
    assert examined == ["m05", "m06", "m07"]
