"""Plans that are added to the cells that they touch, with a session that drops writes in place of Cassandra."""

from collections import Counter
from typing import Any, cast

import numpy as np
import pytest

from ppaas.geometry import poses_along
from ppaas.plans.encoding.index_cells import cells_touched
from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.plans.passage_index import PLANS_PER_CELL, WINDOW, PassageIndex
from storage.cassandra.plans.rows import UnwrittenPlan, plan_rows
from storage.plan_checks import array_of
from tests.support.storage.records import plan

BETWEEN = slice(1, -2)
"""The waypoints of a plan that can be in shared segments."""


class Session:
    """Drops all writes."""

    def write_each(self, cql: str, rows: object) -> None:
        """Do nothing."""


@pytest.fixture
def now() -> list[float]:
    return [0.0]


@pytest.fixture
def index(now: list[float]) -> PassageIndex:
    return PassageIndex(cast(CassandraSession, Session()), lambda: now[0])


def rows_of(seed: int, count: int) -> list[UnwrittenPlan]:
    """Return rows of plans along parts of the same route."""
    random = np.random.default_rng(seed)
    way = np.cumsum(random.normal(0.0, 0.2, (400, 2)), axis=0)
    parts = [np.sort(random.choice(400, 2, replace=False)) for _ in range(count)]
    plans = [
        plan(f"p{number}", poses=poses_along(way[first : last + 1], 0.0).tobytes())
        for number, (first, last) in enumerate(parts)
    ]
    return list(plan_rows(plans, 8))


def named(writes: list[tuple[str, Any]]) -> Counter[tuple[int, int]]:
    return Counter((values[1], values[2]) for _, values in writes)


@pytest.mark.parametrize("seed", range(5))
def test_a_plan_is_added_to_each_cell_that_it_touches_up_to_the_limit(index: PassageIndex, seed: int) -> None:
    passed: Counter[tuple[int, int]] = Counter()
    rows = rows_of(seed, 60)
    for row in rows:
        points = array_of(row.record.poses)[:, :2]
        passed.update(cells_touched(points[BETWEEN] if row.segments else points))
    found = named([write for row in rows for write in index.additions([row])])
    assert found == {cell: min(count, PLANS_PER_CELL) for cell, count in passed.items()}


def test_plans_are_added_again_after_the_window_or_a_removal(index: PassageIndex, now: list[float]) -> None:
    rows = rows_of(1, 40)
    first = named(index.additions(rows))
    assert not named(index.additions(rows)) - first
    now[0] += 1.01 * WINDOW
    assert named(index.additions(rows)) == first
    index.clear(rows)
    assert named(index.additions(rows)) == first
