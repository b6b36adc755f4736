"""While a store is unreachable its plans are queued; afterwards they are sent in order, each once."""

import threading
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput, NotFound, Unavailable
from storage.memory.store import MemoryStore
from storage.records import PlanRecord
from storage.store_and_forward.plan_outbox import PlanOutbox
from storage.store_and_forward.store import StoreAndForward
from tests.support.storage.records import plan, user


class FarStore(MemoryStore):
    """A store that can be unreachable, and can apply writes without acknowledging them."""

    def __init__(self) -> None:
        super().__init__()
        self.unreachable = False
        self.acknowledges = True
        self.refused: set[str] = set()
        self.arrived: list[str] = []
        self.calls = 0

    def add_plans(self, records: Iterable[PlanRecord]) -> int:
        records = list(records)
        self.calls += 1
        if self.unreachable:
            raise Unavailable("far: no node answers")
        if any(record.id in self.refused for record in records):
            raise InvalidInput("far: not this one")
        new = [record.id for record in records if record.id not in self.arrived]
        self.arrived += new
        count = super().add_plans(records)
        if not self.acknowledges:
            raise Unavailable("far: no answer in time")
        return count


@pytest.fixture
def far() -> FarStore:
    return FarStore()


@pytest.fixture
def store(far: FarStore, tmp_path: Path) -> Iterator[StoreAndForward]:
    opened = StoreAndForward(far, PlanOutbox(tmp_path / "outbox.sqlite"), retry=0.01)
    yield opened
    opened.close()


def wait_for(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 10.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.002)


def test_plans_are_not_queued_while_the_store_is_reachable(store: StoreAndForward, far: FarStore) -> None:
    store.add_plan(plan("a"))
    assert far.arrived == ["a"]
    assert store.waiting() == 0


def test_queued_plans_arrive_once_and_in_order(store: StoreAndForward, far: FarStore) -> None:
    far.unreachable = True
    names = [f"p{number}" for number in range(200)]
    for name in names:
        store.add_plan(plan(name))
    assert store.waiting() == 200
    assert far.arrived == []
    far.unreachable = False
    wait_for(lambda: store.waiting() == 0)
    assert far.arrived == names


def test_only_the_first_caller_waits_for_an_unreachable_store(far: FarStore, tmp_path: Path) -> None:
    store = StoreAndForward(far, PlanOutbox(tmp_path / "outbox.sqlite"), retry=60.0)
    far.unreachable = True
    for name in "abc":
        store.add_plan(plan(name))
    assert far.calls <= 2, "one call of the first caller, and one of the retrying thread"
    store.close()


def test_new_plans_are_queued_behind_waiting_ones(store: StoreAndForward, far: FarStore) -> None:
    far.unreachable = True
    store.add_plan(plan("first"))
    started = threading.Event()

    def add_more() -> None:
        for number in range(100):
            store.add_plan(plan(f"p{number}"))
            started.set()

    more = threading.Thread(target=add_more)
    more.start()
    assert started.wait(10.0)
    far.unreachable = False
    more.join()
    wait_for(lambda: store.waiting() == 0)
    assert far.arrived == ["first", *(f"p{number}" for number in range(100))]


def test_a_plan_stored_without_an_acknowledgement_is_stored_once(store: StoreAndForward, far: FarStore) -> None:
    far.acknowledges = False
    store.add_plan(plan("a"))
    far.acknowledges = True
    wait_for(lambda: store.waiting() == 0)
    assert [record.id for record in store.plans("house")] == ["a"]


def test_a_queued_plan_is_found_by_its_id(store: StoreAndForward, far: FarStore) -> None:
    far.unreachable = True
    store.add_plan(plan("a"))
    assert store.plan("a") == plan("a")
    assert store.whole_plans(["a", "b"]) == {"a": plan("a")}


def test_a_removed_queued_plan_is_not_sent(far: FarStore, tmp_path: Path) -> None:
    store = StoreAndForward(far, PlanOutbox(tmp_path / "outbox.sqlite"), retry=60.0)
    far.unreachable = True
    store.add_plan(plan("a"))
    store.remove_plan("a")
    assert store.waiting() == 0
    with pytest.raises(NotFound):
        store.remove_plan("a")
    store.close()


def test_queued_plans_of_a_removed_map_are_not_sent(far: FarStore, tmp_path: Path) -> None:
    store = StoreAndForward(far, PlanOutbox(tmp_path / "outbox.sqlite"), retry=60.0)
    store.add_plans([plan("a"), plan("b", map="yard")])
    far.unreachable = True
    store.add_plans([plan("c"), plan("d", map="yard")])
    assert store.remove_plans("house") == 2
    assert store.waiting() == 1
    assert store.plan("d") == plan("d", map="yard")
    assert far.plan_maps() == ["yard"]
    store.close()


def test_plans_left_by_an_earlier_process_are_sent(far: FarStore, tmp_path: Path) -> None:
    PlanOutbox(tmp_path / "outbox.sqlite").put([plan("a"), plan("b")])
    store = StoreAndForward(far, PlanOutbox(tmp_path / "outbox.sqlite"), retry=0.01)
    wait_for(lambda: far.arrived == ["a", "b"])
    store.close()


def test_a_plan_refused_by_the_store_does_not_block_the_queue(
    store: StoreAndForward, far: FarStore, caplog: pytest.LogCaptureFixture
) -> None:
    far.unreachable = True
    store.add_plans([plan("a"), plan("bad"), plan("b")])
    far.refused.add("bad")
    far.unreachable = False
    wait_for(lambda: store.waiting() == 0)
    assert far.arrived == ["a", "b"]
    assert "bad" in caplog.text


def test_an_invalid_plan_is_not_queued(store: StoreAndForward, far: FarStore) -> None:
    far.unreachable = True
    with pytest.raises(InvalidInput):
        store.add_plans([plan("a"), plan("bad", poses=b"")])
    assert store.waiting() == 0


def test_other_calls_are_forwarded_to_the_store(store: StoreAndForward, far: FarStore) -> None:
    store.add_user(user("ann"))
    assert far.user("ann") == store.user("ann")
