"""Plans are written in the background, and lookups wait for them."""

import asyncio
import threading
from collections.abc import Iterable
from functools import partial

import pytest

from endpoints.services.plan_writer import MAX_WAITING, PlanWriter
from ppaas.errors import InvalidInput, NotFound, Unavailable
from storage.memory.store import MemoryStore
from storage.records import PlanRecord


def plan(name: str) -> PlanRecord:
    return PlanRecord(name, "ann", "house", "v1", "dijkstra", (0, 0, 0), (1, 0, 0), 1.0, 1.0, 0.1, bytes(56), 1.0)


class SlowStore(MemoryStore):
    """Blocks writes until the test allows them."""

    def __init__(self) -> None:
        super().__init__()
        self.released = threading.Event()

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        assert self.released.wait(10.0)
        return super().add_plans(records)


async def test_write_returns_before_the_store_and_settled_waits_for_it() -> None:
    store, writer = SlowStore(), PlanWriter()
    await writer.write(store, lambda: plan("p1"))
    with pytest.raises(NotFound):
        store.plan("p1")
    store.released.set()
    await writer.settled()
    assert store.plan("p1").id == "p1"


async def test_write_waits_while_the_queue_is_full() -> None:
    store, writer = SlowStore(), PlanWriter()
    for number in range(MAX_WAITING):
        await writer.write(store, partial(plan, f"p{number}"))
    more = asyncio.create_task(writer.write(store, lambda: plan("more")))
    await asyncio.sleep(0)
    assert not more.done()
    store.released.set()
    await more
    await writer.settled()
    assert store.plan("more").id == "more"


async def test_a_failed_plan_is_logged_and_leaves_the_queue(caplog: pytest.LogCaptureFixture) -> None:
    class Broken(MemoryStore):
        def add_plans(self, records: Iterable[PlanRecord]) -> int:
            raise Unavailable("the disk is full")

    writer = PlanWriter()
    for number in range(2 * MAX_WAITING):
        await writer.write(Broken(), partial(plan, f"p{number}"))
    await writer.settled()
    assert "the disk is full" in caplog.text


async def test_plans_written_close_together_are_stored_together() -> None:
    written = []

    class Counting(MemoryStore):
        def add_plans(self, records: Iterable[PlanRecord]) -> int:
            written.append(len(list(records)))
            return 0

    store, writer = Counting(), PlanWriter()
    for number in range(5):
        await writer.write(store, partial(plan, f"p{number}"))
    await writer.settled()
    await writer.write(store, partial(plan, "later"))
    await writer.settled()
    assert written == [5, 1]


async def test_an_invalid_plan_does_not_prevent_storing_others(caplog: pytest.LogCaptureFixture) -> None:
    class Choosy(MemoryStore):
        def add_plans(self, records: Iterable[PlanRecord]) -> int:
            records = list(records)
            if any(record.id == "bad" for record in records):
                raise InvalidInput("this one is bad")
            return super().add_plans(records)

    store, writer = Choosy(), PlanWriter()
    for name in ("p1", "bad", "p2"):
        await writer.write(store, partial(plan, name))
    await writer.settled()
    assert [store.plan(name).id for name in ("p1", "p2")] == ["p1", "p2"]
    assert "bad was not stored: this one is bad" in caplog.text
