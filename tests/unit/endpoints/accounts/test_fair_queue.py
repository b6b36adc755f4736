"""Tests of the fair queue: a flood waits behind itself."""

from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from endpoints.accounts.fair_queue import FairQueue, RequestOrigin

FLOOD = RequestOrigin("nobody", "10.0.0.1")
ANN = RequestOrigin("ann", "10.0.0.2")


def drained(queue: FairQueue[str]) -> list[str]:
    return [item for item in iter(queue.pop, None) if item is not None]


def test_an_address_with_one_request_does_not_wait_behind_a_flood() -> None:
    queue: FairQueue[str] = FairQueue(100)
    for number in range(50):
        queue.push(FLOOD, f"flood {number}")
    queue.push(ANN, "ann")
    assert drained(queue)[:3] == ["flood 0", "ann", "flood 1"]


def test_users_of_one_address_take_turns() -> None:
    queue: FairQueue[str] = FairQueue(100)
    for number in range(3):
        queue.push(FLOOD, f"flood {number}")
    queue.push(RequestOrigin("ann", FLOOD.address), "ann")
    assert drained(queue) == ["flood 0", "ann", "flood 1", "flood 2"]


def test_a_known_user_is_served_before_all_others() -> None:
    queue: FairQueue[str] = FairQueue(100)
    for number in range(3):
        queue.push(RequestOrigin(f"guess{number}", ANN.address), f"flood {number}")
    queue.push(ANN._replace(known=True), "ann")
    assert drained(queue)[0] == "ann"


def test_a_full_queue_drops_the_newest_of_the_address_with_most_requests() -> None:
    queue: FairQueue[str] = FairQueue(3)
    for number in range(3):
        assert queue.push(FLOOD, f"flood {number}") is None
    assert queue.push(ANN, "ann") == "flood 2"
    assert queue.push(FLOOD, "flood 3") == "flood 3"
    assert queue.push(ANN._replace(known=True), "ann again") == "flood 1"


def test_a_discarded_item_makes_space() -> None:
    queue: FairQueue[str] = FairQueue(1)
    queue.push(ANN, "first")
    queue.discard(ANN, "first")
    queue.discard(ANN, "first")
    assert len(queue) == 0 and queue.push(ANN, "second") is None


ORIGINS = st.builds(RequestOrigin, st.sampled_from("abc"), st.sampled_from("xyz"), st.booleans())


@given(st.lists(ORIGINS), st.integers(1, 8), st.data())
def test_every_item_is_served_or_dropped_once(origins: list[RequestOrigin], size: int, data: st.DataObject) -> None:
    queue: FairQueue[int] = FairQueue(size)
    out: list[int] = []
    for number, origin in enumerate(origins):
        out += [] if (dropped := queue.push(origin, number)) is None else [dropped]
        if data.draw(st.booleans()):
            out += [] if (served := queue.pop()) is None else [served]
        assert len(queue) <= size
    out += [item for item in iter(queue.pop, None) if item is not None]
    assert Counter(out) == Counter(range(len(origins)))
    assert len(queue) == 0
