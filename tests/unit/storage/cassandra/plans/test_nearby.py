"""In which order plans near two places are read, as no Cassandra is needed to see."""

from collections import namedtuple
from collections.abc import Callable, Iterator
from operator import attrgetter
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from storage.cassandra.connection.session import CassandraSession
from storage.cassandra.plans import nearby
from storage.cassandra.plans.endpoint_cells import NearbyBuckets, cell_key, length_of_cell
from storage.cassandra.plans.nearby import NearbyPlans
from storage.cassandra.plans.representatives import OVERFULL
from storage.plan_query import PlanStoreQuery
from tests.support.storage.records import plan

Row = namedtuple("Row", ["bucket", "spot", "id", "head"])

SEARCH = PlanStoreQuery("house", "v", (1.0, 1.0), (5.0, 1.0), 0.25)
_key = attrgetter("bucket", "spot", "id")


class Tables:
    """Answers as both tables; of each spot two plans are in front."""

    def __init__(self, lying: list[Row]) -> None:
        self.lying = sorted(lying, key=_key)
        self.front: list[Row] = []
        self.asked = 0
        spots: dict[tuple[bytes, int], list[Row]] = {}
        for row in self.lying:
            spots.setdefault((row.bucket, row.spot), []).append(row)
        for spot, rows in spots.items():
            self.front += ([Row(*spot, OVERFULL, b"")] if len(rows) > 2 else []) + rows[:2]
        self.front.sort(key=_key)

    def rows(self, cql: str, *values: Any) -> Iterator[Row]:
        """Answer what is asked of the front."""
        self.asked += 1
        if "IN ?" in cql:
            for bucket in values[0]:
                yield from [row for row in self.front if row.bucket == bucket][: values[1]]
        else:
            bucket, spot, plan_id, most = values
            behind = [row for row in self.front if row.bucket == bucket and (row.spot, row.id) > (spot, plan_id)]
            yield from behind[:most]

    def query_overfull(self, _: str, bucket: bytes, spots: list[int], most: int) -> Callable[[], list[Row]]:
        """Answer what is asked of crowded spots."""
        self.asked += 1
        return lambda: [row for row in self.lying if row.bucket == bucket and row.spot in spots][:most]


def lying(seed: int, count: int) -> list[Row]:
    """Return plans that begin and end around the places, some too far off, some alike."""
    random = np.random.default_rng(seed)
    rows: list[Row] = []
    while len(rows) < count:
        poses = np.zeros((2, 7))
        poses[:, :2] = np.array((SEARCH.start, SEARCH.goal)) + random.uniform(-0.3, 0.3, (2, 2))
        length = random.uniform(4, 5)
        for _ in range(random.choice([1, 2, 5])):
            record = plan(f"p{len(rows):03}", map="house", version="v", poses=poses.tobytes(), length=length)
            rows.append(Row(*cell_key(record), b""))
    return rows


def near(tables: Tables) -> NearbyPlans:
    session = namedtuple("Session", ["rows", "query_async"])(tables.rows, tables.query_overfull)
    return NearbyPlans(cast(CassandraSession, session), NearbyBuckets(SEARCH))


def connecting(rows: list[Row]) -> list[Row]:
    around = NearbyBuckets(SEARCH)
    return [row for row in rows if row.bucket in around.buckets and around.connecting([row])]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 1000), st.integers(0, 80), st.integers(2, 9), st.integers(2, 9), st.integers(1, 5))
def test_all_are_read_however_few_at_a_time(seed, count, first, then, at_once) -> None:
    tables = Tables(lying(seed, count))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(nearby, "FIRST", first)
        patch.setattr(nearby, "NEXT", then)
        patch.setattr(nearby, "OVERFULL_CELLS_AT_ONCE", at_once)
        waiting = near(tables)
        told, rows = set[str](), waiting.first()
        while rows is not None:
            told |= {row.id for row in rows}
            rows = waiting.more(1000, None)
    assert told >= {row.id for row in connecting(tables.lying)}


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 1000), st.integers(0, 200), st.integers(2, 30), st.integers(1, 20))
@example(310, 72, 20, 16)  # enough at some crowded spots, shorter ones at others that were not come to
def test_once_enough_are_found_nothing_shorter_is_left_but_in_crowds(seed, count, first, limit) -> None:
    tables = Tables(lying(seed, count))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(nearby, "FIRST", first)
        waiting, lengths = near(tables), dict[str, int]()
        rows = waiting.first()
        while rows is not None:
            lengths |= {row.id: length_of_cell(row.spot) for row in connecting(rows)}
            shortest = sorted(lengths.values())[:limit]
            rows = waiting.more(limit, shortest[-1] if len(shortest) == limit else None)
    in_front = sorted(length_of_cell(row.spot) for row in connecting(tables.front) if row.id != OVERFULL)[:limit]
    everywhere = sorted(length_of_cell(row.spot) for row in connecting(tables.lying))[:limit]
    assert len(shortest) == len(everywhere)
    assert all(length <= other for length, other in zip(shortest, in_front, strict=False))
    if len(in_front) < limit:
        assert shortest == everywhere


def test_one_question_is_enough_where_enough_are_in_front() -> None:
    tables = Tables(lying(1, 400))
    waiting = near(tables)
    lengths = sorted(length_of_cell(row.spot) for row in connecting(waiting.first()))
    assert len(lengths) > 16
    assert waiting.more(16, lengths[15]) is None
    assert tables.asked == 1


def test_of_plans_that_are_alike_as_many_are_read_as_are_wanted() -> None:
    poses = np.zeros((2, 7))
    poses[:, :2] = SEARCH.start, SEARCH.goal
    same = [Row(*cell_key(plan(f"p{n:02}", map="house", version="v", poses=poses.tobytes())), b"") for n in range(90)]
    waiting = near(Tables(same))
    assert [row.id for row in waiting.first()] == ["p00", "p01"]
    assert [row.id for row in waiting.more(70, None) or ()] == [row.id for row in same[:70]]
    assert waiting.more(70, None) is None
