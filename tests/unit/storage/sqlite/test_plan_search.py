"""The search by ends finds the same plans as a scan, for any number of cells and buckets."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from ppaas.plans.encoding.end_buckets import buckets_near
from storage.plan_query import PlanStoreQuery
from storage.records import PlanRecord
from storage.sqlite import plan_search
from storage.sqlite.store import SqliteStore
from tests.support.storage.records import plan

STEPS = range(-6, 7)


def between(start: tuple[float, float], goal: tuple[float, float], name: str, length: float) -> PlanRecord:
    poses = np.zeros((2, 7))
    poses[:, :2], poses[:, 6] = (start, goal), 1.0
    return plan(name, poses=poses.tobytes(), start=(*start, 0.0), goal=(*goal, 0.0), length=length)


@pytest.fixture(scope="module")
def kept() -> list[PlanRecord]:
    """Return plans whose ends are around a corner of the grid of buckets, a few plans in each cell."""
    return [
        between((0.05 * x, 0.05 * y), (5.0, 0.05 * x), f"p{x}.{y}.{again}", 5.0 + 0.0625 * ((7 * x + 3 * y) % 11))
        for x in STEPS
        for y in STEPS
        for again in range(3)
    ]


@pytest.fixture
def store(tmp_path: Path, kept: list[PlanRecord]) -> Iterator[SqliteStore]:
    store = SqliteStore(tmp_path / "store.db")
    store.add_plans(kept)
    yield store
    store.close()


@pytest.mark.parametrize("limit", [0, 1, 5, 16, 60, 1000])
@pytest.mark.parametrize("tolerance", [0.0, 0.12, 0.25])
def test_the_shortest_plans_near_both_places_are_found(
    store: SqliteStore, kept: list[PlanRecord], tolerance: float, limit: int
) -> None:
    search = PlanStoreQuery("house", "v", (0.0, 0.0), (5.0, 0.0), tolerance)
    near = sorted(one.length for one in kept if search.joins(one.start[:2], one.goal[:2]))
    assert [head.length for head in store.find_plans(search, limit=limit)] == near[:limit]


def test_a_plan_is_found_once_if_two_buckets_have_the_same_hash(
    store: SqliteStore, kept: list[PlanRecord], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plan_search, "buckets_near", lambda *sought: np.repeat(buckets_near(*sought), 2, axis=0))
    search = PlanStoreQuery("house", "v", (0.0, 0.0), (5.0, 0.0), 0.12)
    found = [head.id for head in store.find_plans(search, limit=1000)]
    assert sorted(found) == sorted(one.id for one in kept if search.joins(one.start[:2], one.goal[:2]))
