"""Acknowledged alerts in a store."""

import pytest

from storage.alerts import acknowledgements as module
from storage.alerts.acknowledgements import ALERTS_RECORD, KEPT, Acknowledgement, acknowledge, acknowledgements
from storage.memory.store import MemoryStore
from storage.records import CloneCheckpoint, CloneLogChange


def lost(robot: str, by: str = "ann", time: float = 1e9) -> Acknowledgement:
    return Acknowledgement(object=f"robots/{robot}", alert="lost", by=by, time=time)


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


def test_alerts_of_each_owner_are_kept_and_the_last_acknowledgement_of_one_counts(store: MemoryStore) -> None:
    for owner, one in (("ann", lost("tb1")), ("ann", lost("tb2")), ("bob", lost("tb1")), ("ann", lost("tb1", "eve"))):
        acknowledge(store, owner, one)
    assert sorted(acknowledgements(store, "ann"), key=lambda one: one.object) == [lost("tb1", "eve"), lost("tb2")]
    assert acknowledgements(store, "bob") == [lost("tb1")]
    assert acknowledgements(store, "carl") == []


def test_old_acknowledgements_are_dropped_and_of_too_many_the_oldest(
    store: MemoryStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MOST", 2)
    acknowledge(store, "ann", lost("tb1", time=0.0))
    acknowledge(store, "ann", lost("tb2", time=KEPT + 1.0))
    assert acknowledgements(store, "ann") == [lost("tb2", time=KEPT + 1.0)]
    for number in (5, 4, 3):
        acknowledge(store, "ann", lost(f"tb{number}", time=KEPT + number))
    assert {one.object for one in acknowledgements(store, "ann")} == {"robots/tb3", "robots/tb5"}


def test_a_damaged_acknowledgement_is_left_out(store: MemoryStore, caplog: pytest.LogCaptureFixture) -> None:
    acknowledge(store, "ann", lost("tb1"))
    store.save_clone(CloneCheckpoint("ann", ALERTS_RECORD, {}, 1.0), CloneLogChange("acknowledged", {7: b"\x81"}))
    acknowledge(store, "ann", lost("tb2"))
    assert {one.object for one in acknowledgements(store, "ann")} == {"robots/tb1", "robots/tb2"}
    assert f"clone_logs/ann/{ALERTS_RECORD}/acknowledged/7" in caplog.text
