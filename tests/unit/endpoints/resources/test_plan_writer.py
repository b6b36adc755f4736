"""Plans are written in the background, and lookups wait for them."""

import asyncio
import threading
from collections.abc import Iterable
from functools import partial

import pytest

from endpoints.resources import plan_writer
from endpoints.resources.plan_writer import MAX_WAITING, PlanWriter
from ppaas.errors import InvalidInput, NotFound, Unavailable
from storage.memory.store import MemoryStore
from storage.records import PlanRecord
from tests.support.waiting import until


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


class FullStore(MemoryStore):
    """Takes nothing while it is full."""

    def __init__(self) -> None:
        super().__init__()
        self.is_full = True

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        if self.is_full:
            raise Unavailable("the disk is full")
        return super().add_plans(records)


async def test_plans_that_the_store_cannot_take_wait_and_are_stored_when_it_can(
    caplog: pytest.LogCaptureFixture,
) -> None:
    store, writer = FullStore(), PlanWriter(retry=0.01)
    names = [f"p{number:03}" for number in range(2 * MAX_WAITING)]
    for name in names:
        await writer.write(store, partial(plan, name))
    await writer.settled()
    assert "the disk is full" in caplog.text
    assert (writer.unstored("p001"), writer.unstored("other")) == (plan("p001"), None)
    assert await writer.forget(lambda record: record.id == "p002") == 1
    store.is_full = False
    await until(lambda: writer.unstored(names[-1]) is None)
    assert sorted(head.id for head in store.plans("house")) == [name for name in names if name != "p002"]
    store.is_full = True
    await writer.write(store, partial(plan, "again"))
    await writer.settled()
    assert writer.unstored("again") is not None
    store.is_full = False
    await writer.close()
    assert store.plan("again") == plan("again")


async def test_no_more_plans_are_accepted_than_can_wait(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(plan_writer, "MOST_UNSTORED", 3)
    store, writer = FullStore(), PlanWriter(retry=60.0)
    for number in range(3):
        assert writer.accepts
        await writer.write(store, partial(plan, f"p{number}"))
        await writer.settled()
    assert not writer.accepts
    await writer.forget(lambda record: record.id == "p1")
    assert writer.accepts
    monkeypatch.setattr(plan_writer, "MOST_UNSTORED_BYTES", 2 * 56)
    assert not writer.accepts
    await writer.close()
    assert "2 plans are lost" in caplog.text


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
