"""Recent plans: plans are cached as long as the store has the same ones."""

import msgspec
import pytest

from engine.agent.requests.recent_plans import RecentPlans
from ppaas.errors import NotFound
from storage.memory.store import MemoryStore
from storage.records import PlanRecord
from storage.versions import without_poses
from tests.support.storage.records import plan


class CountingStore(MemoryStore):
    """Store that counts reads of plans."""

    def __init__(self) -> None:
        super().__init__()
        self.read = 0

    def plan(self, plan_id: str) -> PlanRecord:
        self.read += 1
        return super().plan(plan_id)


def test_plan_is_read_from_the_store_once() -> None:
    store = CountingStore()
    store.add_plan(plan("p1"))
    recent = RecentPlans(store)
    assert [recent.plan(without_poses(plan("p1"))) for _ in range(3)] == [plan("p1")] * 3
    assert store.read == 1


def test_replaced_plan_is_read_again() -> None:
    store, changed = CountingStore(), msgspec.structs.replace(plan("p1"), cost=7.0)
    store.add_plan(plan("p1"))
    recent = RecentPlans(store)
    recent.plan(without_poses(plan("p1")))
    store.replace_plan(changed, instead_of=plan("p1"))
    assert recent.plan(without_poses(changed)) == changed
    assert store.read == 2


def test_cache_evicts_the_least_recently_used_plan() -> None:
    store, plans = CountingStore(), [plan(f"p{number}") for number in range(3)]
    store.add_plans(plans)
    recent = RecentPlans(store, most_bytes=2 * len(plans[0].poses))
    for wanted in (0, 1, 0, 2, 0, 1):
        recent.plan(without_poses(plans[wanted]))
    assert store.read == 4, "the third evicted the second, which was then read again"


def test_removed_plan_is_not_found() -> None:
    with pytest.raises(NotFound):
        RecentPlans(CountingStore()).plan(without_poses(plan("p1")))
