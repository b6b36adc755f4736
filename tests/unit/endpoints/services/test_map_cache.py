"""Heads of maps are cached, and read again when they may have changed."""

import asyncio
import threading

import pytest

from endpoints.services.map_cache import MapHeadCache
from ppaas.clock import ManualClock
from ppaas.errors import NotFound, Unavailable
from storage.memory.maps import MemoryMapStore
from storage.records import MapRecord
from tests.support.storage.records import house, put_map


class Counting(MemoryMapStore):
    """Counts queries, and answers when the test allows it."""

    def __init__(self) -> None:
        super().__init__()
        self.asked = 0
        self.begun, self.go_on = threading.Event(), threading.Event()
        self.go_on.set()

    def map_head(self, map_id: str) -> MapRecord:
        self.asked += 1
        head = super().map_head(map_id)
        self.begun.set()
        assert self.go_on.wait(10.0)
        return head


@pytest.fixture
def store() -> Counting:
    return Counting()


def publish(store: Counting, map_id: str = "house", description: str = "") -> None:
    put_map(store, house(map_id, description=description))


async def test_a_map_is_looked_up_once(store: Counting) -> None:
    publish(store)
    heads = MapHeadCache()
    assert (await heads.head(store, "house")).owner == "ann"
    assert (await heads.head(store, "house")).owner == "ann"
    assert store.asked == 1


async def test_what_is_not_there_is_not_remembered_as_such(store: Counting) -> None:
    heads = MapHeadCache()
    with pytest.raises(NotFound):
        await heads.head(store, "house")
    publish(store)
    assert (await heads.head(store, "house")).id == "house"


async def test_a_map_that_changed_is_looked_up_anew(store: Counting) -> None:
    publish(store)
    heads = MapHeadCache()
    await heads.head(store, "house")
    publish(store, description="painted")
    heads.forget("house")
    assert (await heads.head(store, "house")).description == "painted"


async def test_what_was_read_while_it_changed_is_not_believed(store: Counting) -> None:
    publish(store)
    heads = MapHeadCache()
    store.go_on.clear()
    reading = asyncio.create_task(heads.head(store, "house"))
    assert await asyncio.to_thread(store.begun.wait, 10.0)
    publish(store, description="painted")
    heads.forget("house")
    store.go_on.set()
    assert (await reading).description == ""
    assert (await heads.head(store, "house")).description == "painted"


async def test_what_another_process_changed_is_seen_after_a_while(store: Counting) -> None:
    publish(store)
    now = 100.0
    heads = MapHeadCache(lifetime=30.0, clock=lambda: now)
    await heads.head(store, "house")
    publish(store, description="painted")
    now = 129.0
    assert (await heads.head(store, "house")).description == ""
    now = 131.0
    assert (await heads.head(store, "house")).description == "painted"


async def test_the_map_that_was_unused_for_longest_is_forgotten_first(store: Counting) -> None:
    heads = MapHeadCache(size=2)
    for map_id in ("a", "b", "a", "c", "a", "b"):
        if map_id not in {head.id for head in store.maps()}:
            publish(store, map_id)
        await heads.head(store, map_id)
    assert store.asked == 4, "b had to go for c, and was looked up again"


async def test_while_the_store_is_away_a_map_is_as_it_was_of_late(store: Counting) -> None:
    clock, away = ManualClock(0.0), Away()
    publish(store)
    heads = MapHeadCache(clock=clock, lifetime=30.0, patience=100.0)
    head = await heads.head(store, "house")
    for now, asked in ((31.0, 1), (35.0, 1), (37.0, 2)):
        clock.now = now
        assert await heads.head(away, "house") == head
        assert away.asked == asked, "it is not waited for each time"
    clock.now = 101.0
    with pytest.raises(Unavailable):
        await heads.head(away, "house")
    with pytest.raises(Unavailable):
        await heads.head(away, "depot")


class Away(MemoryMapStore):
    """Raises ``Unavailable``."""

    def __init__(self) -> None:
        super().__init__()
        self.asked = 0

    def map_head(self, map_id: str) -> MapRecord:
        self.asked += 1
        raise Unavailable("no node answers")
