"""Caches of services: heads of maps, which are read again when they may have changed, and refused connects."""

import asyncio
import threading

import pytest

from endpoints.resources.services import MOST_ROBOTS, MapHeadCache, RefusedConnect, RefusedConnects
from ppaas.clock import ManualClock
from ppaas.errors import Conflict, NotFound, Unavailable
from storage.memory.maps import MemoryMapStore
from storage.records import MapRecord
from tests.support.storage.records import house, put_map


class Counting(MemoryMapStore):
    """Counts queries, and answers when the test allows it."""

    def __init__(self) -> None:
        super().__init__()
        self.asked = 0
        self.begun, self.released = threading.Event(), threading.Event()
        self.released.set()

    def map_head(self, map_id: str) -> MapRecord:
        self.asked += 1
        head = super().map_head(map_id)
        self.begun.set()
        assert self.released.wait(10.0)
        return head


@pytest.fixture
def store() -> Counting:
    return Counting()


def publish(store: Counting, map_id: str = "house", description: str = "") -> None:
    put_map(store, house(map_id, description=description))


async def test_a_cached_head_is_read_once(store: Counting) -> None:
    publish(store)
    heads = MapHeadCache()
    assert (await heads.head(store, "house")).owner == "ann"
    assert (await heads.head(store, "house")).owner == "ann"
    assert store.asked == 1


async def test_a_missing_map_is_not_cached(store: Counting) -> None:
    heads = MapHeadCache()
    with pytest.raises(NotFound):
        await heads.head(store, "house")
    publish(store)
    assert (await heads.head(store, "house")).id == "house"


async def test_a_forgotten_head_is_read_again(store: Counting) -> None:
    publish(store)
    heads = MapHeadCache()
    await heads.head(store, "house")
    publish(store, description="painted")
    heads.forget("house")
    assert (await heads.head(store, "house")).description == "painted"


async def test_a_head_read_during_a_change_is_not_cached(store: Counting) -> None:
    publish(store)
    heads = MapHeadCache()
    store.released.clear()
    reading = asyncio.create_task(heads.head(store, "house"))
    assert await asyncio.to_thread(store.begun.wait, 10.0)
    publish(store, description="painted")
    heads.forget("house")
    store.released.set()
    assert (await reading).description == ""
    assert (await heads.head(store, "house")).description == "painted"


async def test_changes_of_another_process_are_seen_after_the_lifetime(store: Counting) -> None:
    publish(store)
    now = 100.0
    heads = MapHeadCache(lifetime=30.0, clock=lambda: now)
    await heads.head(store, "house")
    publish(store, description="painted")
    now = 129.0
    assert (await heads.head(store, "house")).description == ""
    now = 131.0
    assert (await heads.head(store, "house")).description == "painted"


async def test_the_least_recently_used_head_is_evicted(store: Counting) -> None:
    heads = MapHeadCache(size=2)
    for map_id in ("a", "b", "a", "c", "a", "b"):
        if map_id not in {head.id for head in store.maps()}:
            publish(store, map_id)
        await heads.head(store, map_id)
    assert store.asked == 4, "b was evicted for c and read again"


async def test_cached_heads_are_served_while_the_store_is_unreachable(store: Counting) -> None:
    clock, unreachable = ManualClock(0.0), Unreachable()
    publish(store)
    heads = MapHeadCache(clock=clock, lifetime=30.0, patience=100.0)
    head = await heads.head(store, "house")
    for now, asked in ((31.0, 1), (35.0, 1), (37.0, 2)):
        clock.now = now
        assert await heads.head(unreachable, "house") == head
        assert unreachable.asked == asked, "the store is not queried each time"
    clock.now = 101.0
    with pytest.raises(Unavailable):
        await heads.head(unreachable, "house")
    with pytest.raises(Unavailable):
        await heads.head(unreachable, "depot")


class Unreachable(MemoryMapStore):
    """Raises ``Unavailable``."""

    def __init__(self) -> None:
        super().__init__()
        self.asked = 0

    def map_head(self, map_id: str) -> MapRecord:
        self.asked += 1
        raise Unavailable("no node answers")


def refuse(refused: RefusedConnects, robot: str, role: str = "robot") -> None:
    with pytest.raises(Conflict), refused.attempt("ann", robot, role):
        raise Conflict("it is connected already")


# Last refusals of robots that tried to connect.


def test_refusal_is_kept_with_its_age_until_the_robot_connects() -> None:
    clock = ManualClock()
    refused = RefusedConnects(clock)
    refuse(refused, "tb1")
    clock.advance(7.0)
    assert refused.last("ann", "tb1") == RefusedConnect("conflict: it is connected already", 7.0)
    assert refused.last("bob", "tb1") is None
    with refused.attempt("ann", "tb1", "robot"):
        pass
    assert refused.last("ann", "tb1") is None


def test_operators_do_not_count() -> None:
    refused = RefusedConnects()
    refuse(refused, "tb1", "operator")
    assert refused.last("ann", "tb1") is None
    refuse(refused, "tb1")
    with refused.attempt("ann", "tb1", "operator"):
        pass
    assert refused.last("ann", "tb1") is not None


def test_number_of_robots_is_bounded() -> None:
    refused = RefusedConnects()
    for number in range(MOST_ROBOTS + 1):
        refuse(refused, f"tb{number}")
    assert refused.last("ann", "tb0") is None
    assert refused.last("ann", f"tb{MOST_ROBOTS}") is not None
